#include "framework/io/mitsuba/xml.h"

#include "framework/io/text.h"

#include <fmt/format.h>
#include <pugixml.hpp>

#include <algorithm>
#include <filesystem>
#include <optional>

namespace etendue {

namespace fs = std::filesystem;

namespace {

constexpr int most_nested = 64;
constexpr std::size_t most_folders = 100;  // of <path>, each of which is asked for each file
constexpr std::size_t most_elements = 1'000'000, most_bytes = std::size_t{1} << 26, most_replaced_bytes = std::size_t{1} << 24;

bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_lower_or_digit(char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); }
char lower(char c) { return is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c; }
bool is_name(char c) { return is_upper(c) || is_lower_or_digit(c) || c == '_'; }

// A file or folder of this name, with its backslashes or with slashes for them.
std::optional<fs::path> existing_in(const fs::path& folder, std::string name) {
  std::error_code ignored;
  if (fs::exists(folder / name, ignored)) return folder / name;
  std::replace(name.begin(), name.end(), '\\', '/');
  return fs::exists(folder / name, ignored) ? std::optional(folder / name) : std::nullopt;
}

std::vector<std::size_t> find_line_starts(std::string_view text) {
  std::vector<std::size_t> starts{0};
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '\n' || (text[i] == '\r' && (i + 1 == text.size() || text[i + 1] != '\n'))) starts.push_back(i + 1);
  return starts;
}

}  // namespace

// The places of the text are kept, for pugixml writes into it.
struct XmlTree::Parsing {
  std::string text;
  std::shared_ptr<const std::string> file;
  int nested;
  std::vector<std::size_t> line_starts = find_line_starts(text);
  pugi::xml_document document = {};

  XmlPlace place(std::size_t offset) const {
    const auto next = std::upper_bound(line_starts.begin(), line_starts.end(), offset);
    return {static_cast<int>(next - line_starts.begin()), static_cast<int>(offset - *(next - 1)) + 1};
  }
  XmlPlace place_of(const char* in_text, XmlPlace otherwise) const {
    const std::less_equal<const char*> before;
    const bool inside = before(text.data(), in_text) && before(in_text, text.data() + text.size());
    return inside ? place(static_cast<std::size_t>(in_text - text.data())) : otherwise;
  }
  Location where(std::size_t offset) const {
    const XmlPlace at = place(offset);
    return {*file, at.line, at.column};
  }
};

std::string snake_case(std::string_view name) {
  std::string snake;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (i > 0 && is_upper(name[i]) && is_lower_or_digit(name[i - 1])) snake += '_';
    snake += lower(name[i]);
  }
  return snake;
}

const XmlAttribute* XmlElement::find(std::string_view name) const {
  for (const XmlAttribute& attribute : attributes)
    if (attribute.name == name) return &attribute;
  return nullptr;
}

std::string XmlElement::value(std::string_view name) const {
  const XmlAttribute* attribute = find(name);
  return attribute ? attribute->value : "";
}

Location XmlElement::where(std::string_view name) const {
  const XmlAttribute* attribute = find(name);
  return attribute ? Location{*file, attribute->place.line, attribute->place.column} : where();
}

XmlTree::XmlTree(std::string text, const std::string& path, SceneFiles& files) : files_(files) {
  root_ = parse(std::move(text), path, 0);
}

XmlElement XmlTree::parse(std::string text, const std::string& path, int nested) {
  if (text.size() > most_bytes)
    throw Error(Location{path}, fmt::format("the file has {} MiB; expected {} at most, and meshes in files of their own",
                                            text.size() >> 20, most_bytes >> 20));
  if (const std::size_t zero = text.find('\0'); zero != std::string::npos)
    throw Error(location_at(path, text, zero), "no Mitsuba scene: expected XML in UTF-8, found a zero byte");
  Parsing parsing{std::move(text), std::make_shared<const std::string>(path), nested};
  const pugi::xml_parse_result result = parsing.document.load_buffer_inplace(
      parsing.text.data(), parsing.text.size(), pugi::parse_default | pugi::parse_doctype, pugi::encoding_utf8);
  if (!result)
    throw Error(parsing.where(static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0))),
                fmt::format("no XML: {}", result.description()));
  for (const pugi::xml_node node : parsing.document.children())
    if (node.type() == pugi::node_doctype)
      throw Error(parsing.where(0), "a document type (<!DOCTYPE ...>) is not supported: entities are not read");
  const pugi::xml_node root = parsing.document.document_element();
  // Any file of the disk may be included, and its words are not for a message.
  const std::string_view name = root.name();
  const bool is_object = nested > 0 && (name == "bsdf" || name == "shape" || name == "emitter" || name == "texture" ||
                                        name == "sensor" || name == "integrator" || name == "medium");
  if (name != "scene" && !is_object)
    throw Error(parsing.where(root ? static_cast<std::size_t>(std::max<std::ptrdiff_t>(root.offset_debug() - 1, 0)) : 0),
                "no Mitsuba scene: expected the root element <scene>");
  XmlElement element;
  convert(parsing, &root, element, 0);
  return element;
}

void XmlTree::convert(const Parsing& parsing, const void* opaque, XmlElement& element, int depth) {
  const pugi::xml_node& node = *static_cast<const pugi::xml_node*>(opaque);
  element.tag = node.name();
  std::transform(element.tag.begin(), element.tag.end(), element.tag.begin(), lower);
  element.file = parsing.file;
  element.place = parsing.place(static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug() - 1, 0)));
  if (depth > most_nested) throw Error(element.where(), fmt::format("elements nest more than {} deep", most_nested));
  if (++elements_ > most_elements)
    throw Error(element.where(), fmt::format("the scene has more than {} elements", most_elements));
  for (const pugi::xml_attribute a : node.attributes())
    element.attributes.push_back({a.name(), a.value(), parsing.place_of(a.value(), element.place)});
  replace_names(element);
  if (element.tag == "default") define(element);
  for (const pugi::xml_node child : node.children()) {
    if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata)
      throw Error(parsing.where(static_cast<std::size_t>(std::max<std::ptrdiff_t>(child.offset_debug(), 0))),
                  "text between elements; expected elements and comments only");
    if (child.type() == pugi::node_element) convert_child(parsing, &child, element, depth);
  }
}

void XmlTree::convert_child(const Parsing& parsing, const void* node, XmlElement& parent, int depth) {
  XmlElement element;
  convert(parsing, node, element, depth + 1);
  if (element.tag == "path" && depth == 0) add_folder(element);
  if (element.tag == "include")
    include(element, parent, parsing.nested + 1);
  else if (element.tag != "default")
    parent.children.push_back(std::move(element));
}

// It is relative to the file it stands in, or else to the folders before it, or to the first file.
void XmlTree::add_folder(const XmlElement& path) {
  const std::string value = path.value("value"), &here = *path.file;
  if (value.empty()) throw Error(path.where(), "path: 'value' is missing");
  if (folders_.size() == most_folders)
    throw Error(path.where(), fmt::format("the scene names more than {} folders by path", most_folders));
  for (const std::string& file : {here, looked_for_beside(value, here), files_.first_file()})
    if (const auto folder = existing_in(fs::path(file).parent_path(), value)) return folders_.push_back(folder->string());
  files_.warn(path.where(), fmt::format("path: there is no folder {}", quote(value)));
}

std::string XmlTree::looked_for_beside(const std::string& name, const std::string& named_in) const {
  if (fs::path(name).is_absolute()) return named_in;
  for (auto folder = folders_.rbegin(); folder != folders_.rend(); ++folder)
    if (existing_in(*folder, name)) return *folder + "/";
  return named_in;
}

void XmlTree::include(const XmlElement& element, XmlElement& parent, int nested) {
  const std::string name = element.value("filename");
  if (name.empty()) throw Error(element.where(), "include: 'filename' is missing");
  if (nested > SceneFiles::most_nested_includes)
    throw Error(element.where(), fmt::format("files include each other more than {} deep: does one include itself?",
                                             SceneFiles::most_nested_includes));
  const std::string &here = *element.file, beside = looked_for_beside(name, here);
  if (beside != here && existing_in(fs::path(here).parent_path(), name))
    files_.warn(
        element.where("filename"),
        fmt::format("include: {} lies in a folder of path, which counts, and beside this file as well, where the newest "
                    "Mitsuba 3 looks first",
                    quote(name)));
  SceneFiles::File file = files_.include(name, beside, element.where("filename"));
  XmlElement included = parse(std::move(file.bytes), file.path, nested);
  if (included.tag != "scene") {
    parent.children.push_back(std::move(included));
    return;
  }
  for (XmlElement& child : included.children) parent.children.push_back(std::move(child));
}

// What is defined first stays, so that a file may give defaults to those it includes.
void XmlTree::define(const XmlElement& element) {
  const XmlAttribute *name = element.find("name"), *value = element.find("value");
  if (!name || !value || name->value.empty()) throw Error(element.where(), "default: expected the attributes name and value");
  defaults_.emplace(name->value, value->value);
}

void XmlTree::replace_names(XmlElement& element) {
  for (XmlAttribute& attribute : element.attributes)
    if (attribute.value.find('$') != std::string::npos) attribute.value = replaced(element, attribute);
}

// The longest is meant of several names that fit.
std::string XmlTree::replaced(const XmlElement& element, const XmlAttribute& attribute) {
  const std::string& text = attribute.value;
  std::string result;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] != '$') {
      result += text[i++];
      continue;
    }
    std::size_t end = i + 1;
    while (end < text.size() && is_name(text[end])) ++end;
    const std::string whole = text.substr(i + 1, end - i - 1);
    auto found = defaults_.end();
    for (std::size_t length = whole.size(); length > 0 && found == defaults_.end(); --length)
      found = defaults_.find(std::string_view(whole).substr(0, length));
    if (found == defaults_.end()) {
      std::vector<std::string> names;
      for (const auto& [name, value] : defaults_) names.push_back(name);
      throw Error(element.where(attribute.name),
                  unknown_name("parameter", whole, names) + "; expected <default name=\"...\" value=\"...\"/> before it");
    }
    result += found->second;
    i += 1 + found->first.size();
    replaced_bytes_ += found->second.size();
    if (replaced_bytes_ > most_replaced_bytes)
      throw Error(element.where(attribute.name),
                  fmt::format("replacing $names adds more than {} MiB", most_replaced_bytes >> 20));
  }
  return result;
}

}  // namespace etendue
