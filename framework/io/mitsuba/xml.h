// The elements of an XML scene and of the files it includes, with `$name` replaced by what `default` says of it.
//
// A scene from elsewhere is not trusted. Elements nest at most 64 deep, includes at most SceneFiles::most_nested_includes; a
// document type, which could define entities, is refused; there are limits to the number of elements, and to the text that
// replacing adds.
#pragma once

#include "framework/io/scene_files.h"

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace etendue {

// "toWorld" and "to_world" are both "to_world", "intIOR" is "int_ior".
std::string snake_case(std::string_view name);

struct XmlPlace {
  int line = 0, column = 0;
};

struct XmlAttribute {
  std::string name, value;
  XmlPlace place;  // of the value
};

struct XmlElement {
  std::string tag;  // lower case
  std::shared_ptr<const std::string> file;
  XmlPlace place;
  std::vector<XmlAttribute> attributes;
  std::vector<XmlElement> children;

  const XmlAttribute* find(std::string_view name) const;
  std::string value(std::string_view name) const;  // "" where it is missing
  Location where() const { return {*file, place.line, place.column}; }
  Location where(std::string_view attribute) const;  // of its value, or of the element where it is missing
};

class XmlTree {
 public:
  // Throws Error at `file:line:col`. What a file says is shown in messages only once its root is known as a scene's.
  XmlTree(std::string text, const std::string& path, SceneFiles& files);
  const XmlElement& root() const { return root_; }
  // The file beside which a file is to be looked for that an element of `named_in` names: one in the last folder of <path> that
  // has such a file, since Mitsuba looks there before it looks beside the scene, or else `named_in`.
  std::string looked_for_beside(const std::string& name, const std::string& named_in) const;

 private:
  struct Parsing;
  XmlElement parse(std::string text, const std::string& path, int nested);
  void convert(const Parsing& parsing, const void* node, XmlElement& element, int depth);
  void convert_child(const Parsing& parsing, const void* node, XmlElement& parent, int depth);
  void include(const XmlElement& element, XmlElement& parent, int nested);
  void define(const XmlElement& element);
  void add_folder(const XmlElement& path);
  void replace_names(XmlElement& element);
  std::string replaced(const XmlElement& element, const XmlAttribute& attribute);

  SceneFiles& files_;
  XmlElement root_;
  std::map<std::string, std::string, std::less<>> defaults_;
  std::vector<std::string> folders_;  // of <path>, in their order
  std::size_t elements_ = 0, replaced_bytes_ = 0;
};

}  // namespace etendue
