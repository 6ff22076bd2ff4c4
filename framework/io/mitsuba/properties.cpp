#include "framework/io/mitsuba/properties.h"

#include "framework/core/lists.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace etendue {

namespace {

constexpr std::array values{"float", "integer", "boolean",  "string",    "point",     "vector",
                            "rgb",   "srgb",    "spectrum", "blackbody", "transform", "animation"};
constexpr std::array objects{"bsdf",       "shape",   "emitter", "luminaire", "sensor", "camera",  "film",      "sampler",
                             "integrator", "texture", "medium",  "volume",    "phase",  "rfilter", "subsurface"};
constexpr std::array others{"ref", "alias", "path"};

void check_tag(const XmlElement& element) {
  if (contains(values, element.tag) || contains(objects, element.tag) || contains(others, element.tag)) return;
  std::vector<std::string> names(values.begin(), values.end());
  names.insert(names.end(), objects.begin(), objects.end());
  names.insert(names.end(), others.begin(), others.end());
  throw Error(element.where(), unknown_name("element", element.tag, names));
}

// Before version 2 the names of other objects are labels.
bool is_found_by_name(const XmlElement& element) {
  return contains(values, element.tag) || element.tag == "texture" || element.tag == "medium" || element.tag == "volume" ||
         element.tag == "phase";
}

bool is_same(const XmlElement& a, const XmlElement& b) {
  return a.tag == b.tag &&
         std::equal(a.attributes.begin(), a.attributes.end(), b.attributes.begin(), b.attributes.end(),
                    [](const XmlAttribute& x, const XmlAttribute& y) { return x.name == y.name && x.value == y.value; }) &&
         std::equal(a.children.begin(), a.children.end(), b.children.begin(), b.children.end(), is_same);
}

}  // namespace

void XmlIds::add(const XmlElement& element) {
  const std::string id = element.value("id");
  if (element.tag == "alias") {
    aliases_.emplace(element.value("as"), id);
  } else if (element.tag != "ref" && !id.empty()) {
    const auto [object, is_new] = objects_.emplace(id, &element);
    if (!is_new && !is_same(*object->second, element)) doubles_.insert(id);
  }
  for (const XmlElement& child : element.children) add(child);
}

const XmlElement& XmlIds::find(const XmlElement& ref) const {
  std::string id = ref.value("id");
  if (id.empty()) throw Error(ref.where(), "ref: 'id' is missing");
  const Location where = ref.where("id");
  if (const auto alias = aliases_.find(id); alias != aliases_.end()) id = alias->second;
  if (doubles_.contains(id)) throw Error(where, fmt::format("{} is the id of two objects; expected one", quote(id)));
  const auto found = objects_.find(id);
  if (found != objects_.end()) return *found->second;
  std::vector<std::string> names;
  for (const auto& [name, object] : objects_) names.push_back(name);
  throw Error(where, unknown_name("id", id, names));
}

Properties::Properties(const XmlElement& element, const XmlIds& ids, const Tell* lenient)
    : element_(element), lenient_(lenient), type_(element.value("type")) {
  if (lenient_) type_ = in_lower_case(type_);
  std::set<std::string> names;
  for (const XmlElement& child : element.children) {
    check_tag(child);
    if (child.tag == "alias" || child.tag == "path") continue;
    Entry entry{snake_case(child.value("name")), &child, &child};
    if (child.tag == "ref") entry.meant = &ids.find(child);
    if (entry.name.empty() && contains(values, child.tag))
      throw Error(child.where(), fmt::format("{}: 'name' is missing", child.tag));
    if (lenient_ && !is_found_by_name(*entry.meant)) entry.name.clear();
    if (!lenient_ && !entry.name.empty() && !names.insert(entry.name).second)
      throw Error(child.where(), fmt::format("{}: '{}' is given twice", title(), child.value("name")));
    entries_.push_back(std::move(entry));
  }
}

std::string Properties::title() const { return type_.empty() ? element_.tag : fmt::format("{} \"{}\"", element_.tag, type_); }

const Properties::Entry* Properties::find(std::string_view name) const {
  asked_.emplace(name);
  const Entry* found = nullptr;
  for (const Entry& entry : entries_) {
    if (entry.name != name) continue;
    entry.used = true;
    if (!found || contains(values, found->meant->tag) || !contains(values, entry.meant->tag)) found = &entry;
  }
  return found;
}

Location Properties::where(std::string_view name) const {
  for (const Entry& entry : entries_)
    if (entry.name == name) return entry.written->where();
  return where();
}

void Properties::fail(std::string_view name, const std::string& what) const {
  throw Error(where(name), fmt::format("{}: '{}' {}", title(), name, what));
}

const Properties::Entry* Properties::find_typed(std::string_view name, std::initializer_list<std::string_view> tags,
                                                std::string_view expected) const {
  const Entry* entry = find(name);
  if (entry && std::find(tags.begin(), tags.end(), entry->meant->tag) == tags.end())
    fail(name, fmt::format("is a {}; expected {}", entry->meant->tag, expected));
  return entry;
}

float Properties::number(std::string_view name, float otherwise, float low, float high) const {
  const Entry* entry = find_typed(name, {"float", "integer"}, "a float");
  if (!entry) return otherwise;
  const float value = read_number(*entry->meant, "value");
  if (!(value >= low && value <= high)) {
    const bool from = low > -std::numeric_limits<float>::max(), to = high < std::numeric_limits<float>::max();
    fail(name, fmt::format("is {}; expected {}", value,
                           from && to ? fmt::format("{:g} to {:g}", low, high)
                           : from     ? fmt::format("{:g} at least", low)
                                      : fmt::format("{:g} at most", high)));
  }
  return value;
}

int Properties::integer(std::string_view name, int otherwise, int low, int high) const {
  const Entry* entry = find_typed(name, {"integer", "float"}, "an integer");
  if (!entry) return otherwise;
  const float value = read_number(*entry->meant, "value");
  if (value != std::floor(value) || value < static_cast<float>(low) || value > static_cast<float>(high))
    fail(name, fmt::format("is {}; expected a whole number of {} to {}", value, low, high));
  return static_cast<int>(value);
}

bool Properties::boolean(std::string_view name, bool otherwise) const {
  const Entry* entry = find_typed(name, {"boolean"}, "a boolean");
  if (!entry) return otherwise;
  const std::string value = entry->meant->value("value");
  if (in_lower_case(value) == "true") return true;
  if (in_lower_case(value) == "false") return false;
  fail(name, fmt::format("is {}; expected true or false", quote(value)));
}

std::string Properties::string(std::string_view name, const std::string& otherwise) const {
  const Entry* entry = find_typed(name, {"string"}, "a string");
  return entry ? entry->meant->value("value") : otherwise;
}

vec3 Properties::point(std::string_view name, const vec3& otherwise) const {
  const Entry* entry = find_typed(name, {"point", "vector"}, "a point or a vector");
  return entry ? read_vector(*entry->meant, vec3(0)) : otherwise;
}

Transform Properties::transform(std::string_view name) const {
  const Entry* entry = find_typed(name, {"transform", "animation"}, "a transform");
  if (!entry) return Transform();
  if (entry->meant->tag == "transform") return read_transform(*entry->meant);
  const std::vector<XmlElement>& keys = entry->meant->children;
  if (keys.empty() || !std::ranges::all_of(keys, [](const XmlElement& key) { return key.tag == "transform"; }))
    throw Error(entry->meant->where(), "animation: expected transforms");
  const auto time = [](const XmlElement& key) { return key.find("time") ? read_number(key, "time") : 0; };
  return read_transform(*std::ranges::min_element(keys, {}, time));
}

const XmlElement* Properties::element(std::string_view name) const {
  const Entry* entry = find(name);
  return entry ? entry->meant : nullptr;
}

std::vector<const XmlElement*> Properties::objects(std::initializer_list<std::string_view> tags) const {
  std::vector<const XmlElement*> found;
  for (const Entry& entry : entries_)
    if (!entry.used && std::find(tags.begin(), tags.end(), entry.meant->tag) != tags.end()) {
      entry.used = true;
      found.push_back(entry.meant);
    }
  return found;
}

bool Properties::has_object(std::initializer_list<std::string_view> tags) const {
  return std::ranges::any_of(
      entries_, [&](const Entry& entry) { return std::find(tags.begin(), tags.end(), entry.meant->tag) != tags.end(); });
}

std::vector<std::pair<std::string, const XmlElement*>> Properties::named_objects(std::string_view tag) const {
  std::vector<std::pair<std::string, const XmlElement*>> found;
  for (const Entry& entry : entries_)
    if (entry.meant->tag == tag) {
      entry.used = true;
      found.emplace_back(entry.written->value("name"), entry.meant);
    }
  return found;
}

void Properties::ignore(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names) find(name);
}

void Properties::ignore_all() const {
  for (const Entry& entry : entries_) entry.used = true;
}

void Properties::finish_but_for_others() const {
  const std::vector<std::string> known(asked_.begin(), asked_.end());
  for (const Entry& entry : entries_) entry.used = entry.used || nearest_names(entry.name, known, 1).empty();
  finish();
}

void Properties::finish() const {
  const std::vector<std::string> known(asked_.begin(), asked_.end());
  for (const Entry& entry : entries_) {
    if (entry.used) continue;
    if (entry.name.empty())
      throw Error(entry.written->where(), fmt::format("{}: a {} has no place in it", title(), entry.meant->tag));
    const std::string name = entry.written->value("name");
    if (!lenient_ || !contains(values, entry.meant->tag) || !nearest_names(entry.name, known, 1).empty())
      throw Error(entry.written->where(), fmt::format("{}: {}", title(), unknown_name("property", name, known)));
    (*lenient_)(entry.written->where(), fmt::format("{}: {} has no effect, as in Mitsuba 0.x", title(), quote(name)));
  }
  if (lenient_) tell_of_doubles();
}

void Properties::tell_of_doubles() const {
  std::set<std::string_view> names;
  for (const Entry& entry : entries_)
    if (!entry.name.empty() && !names.insert(entry.name).second)
      (*lenient_)(entry.written->where(),
                  fmt::format("{}: '{}' is given twice: as in Mitsuba 0.x the last counts, and a texture "
                              "before a value",
                              title(), entry.name));
}

}  // namespace etendue
