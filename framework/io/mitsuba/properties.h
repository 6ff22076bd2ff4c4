// The contents of an object of a Mitsuba scene: its properties by name, and the objects in it.
#pragma once

#include "framework/io/mitsuba/xml.h"
#include "framework/scene/transform.h"

#include <functional>
#include <initializer_list>
#include <limits>
#include <optional>
#include <set>

namespace etendue {

// Objects by their ids, wherever in the scene they stand.
class XmlIds {
 public:
  explicit XmlIds(const XmlElement& root) { add(root); }
  // The object that a `ref` names. Throws Error with the nearest ids.
  const XmlElement& find(const XmlElement& ref) const;

 private:
  void add(const XmlElement& element);

  std::map<std::string, const XmlElement*, std::less<>> objects_;
  std::map<std::string, std::string, std::less<>> aliases_;  // another id of the same object
  std::set<std::string, std::less<>> doubles_;
};

// Names are given in snake case. What no function asked for is an error at finish().
//
// Before version 2 Mitsuba is lenient, and a reader of such files gives a function that takes its warnings. Types may then be
// written in capitals; names of objects are labels that may be given twice; of values of one name the last counts, and a
// texture before them; and values that no function asked for have no effect, unless their names look like known ones.
class Properties {
 public:
  using Tell = std::function<void(const Location&, const std::string&)>;
  Properties(const XmlElement& element, const XmlIds& ids, const Tell* lenient = nullptr);

  const XmlElement& element() const { return element_; }
  const std::string& type() const { return type_; }
  std::string title() const;  // bsdf "diffuse"
  Location where() const { return element_.where(); }
  Location where(std::string_view name) const;

  bool has(std::string_view name) const { return find(name) != nullptr; }
  float number(std::string_view name, float otherwise, float low = -std::numeric_limits<float>::max(),
               float high = std::numeric_limits<float>::max()) const;
  int integer(std::string_view name, int otherwise, int low, int high) const;
  bool boolean(std::string_view name, bool otherwise) const;
  std::string string(std::string_view name, const std::string& otherwise) const;
  vec3 point(std::string_view name, const vec3& otherwise) const;
  Transform transform(std::string_view name) const;  // identity where it is missing; of an animation the first
  // A colour or a texture, references followed; nullptr where it is missing.
  const XmlElement* element(std::string_view name) const;
  // The objects with one of these tags that no property names, references followed.
  std::vector<const XmlElement*> objects(std::initializer_list<std::string_view> tags) const;

  bool has_object(std::initializer_list<std::string_view> tags) const;
  // Those with this tag and their names as they are written, references followed.
  std::vector<std::pair<std::string, const XmlElement*>> named_objects(std::string_view tag) const;

  void ignore(std::initializer_list<std::string_view> names) const;
  void ignore_all() const;
  // Serves objects whose other properties change nothing here: what looks like a known name and is none is an error all the
  // same.
  void finish_but_for_others() const;
  void finish() const;
  [[noreturn]] void fail(std::string_view name, const std::string& what) const;

 private:
  struct Entry {
    std::string name;  // "" of an object without one
    const XmlElement* written;
    const XmlElement* meant;  // another behind a reference
    mutable bool used = false;
  };
  void tell_of_doubles() const;
  const Entry* find(std::string_view name) const;
  const Entry* find_typed(std::string_view name, std::initializer_list<std::string_view> tags, std::string_view expected) const;

  const XmlElement& element_;
  const Tell* lenient_;
  std::string type_;
  std::vector<Entry> entries_;
  mutable std::set<std::string, std::less<>> asked_;  // the names that are known here
};

// transforms.cpp. The numbers of an attribute, separated by blanks or commas. Throws Error.
std::vector<float> read_numbers(const XmlElement& element, std::string_view attribute);
float read_number(const XmlElement& element, std::string_view attribute);
// x, y and z, or one value for all three, or three.
vec3 read_vector(const XmlElement& element, const vec3& otherwise);
// The first operation is applied first. Throws Error on what has no inverse.
Transform read_transform(const XmlElement& element);

}  // namespace etendue
