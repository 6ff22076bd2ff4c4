// OBJ files. Before version 2 the lines g and usemtl set meshes of their own apart, in each of which vertices of the same place
// are one, and normals that the file does not have are smooth within each. A bsdf with a name is that of the faces of this
// material; one without a name is that of all faces. shape_index takes one mesh alone. Later versions ask for none of this.

#include "framework/io/mesh/obj.h"
#include "framework/io/mitsuba/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace etendue {

namespace {

constexpr int most_parts = 1 << 24;

bool is_named(const std::pair<std::string, const XmlElement*>& bsdf) { return !bsdf.first.empty(); }

// Does a line that begins a part follow the last face?
bool ends_with_part(std::string_view text) {
  bool begins = false;
  for (WordReader words(text); !words.at_end(); words.next_line()) {
    const std::string_view first = words.word();
    if (first == "f")
      begins = false;
    else if (first == "g" || first == "usemtl")
      begins = true;
  }
  return begins;
}

}  // namespace

// Mitsuba gives a part its number where the next one begins, so that the last one comes with the part before it.
void MitsubaReader::take_obj_part(const Properties& of, std::string_view text, std::vector<ObjPart>& parts) {
  const auto index = static_cast<std::size_t>(of.integer("shape_index", 0, 0, most_parts));
  const bool all_numbered = !of.boolean("collapse", false) && ends_with_part(text);
  const std::size_t numbered = all_numbered ? parts.size() : parts.size() - 1;
  if (index >= numbered)
    of.fail("shape_index", fmt::format("is {}; '{}' has {} parts behind which g or usemtl follows, and Mitsuba loads no other",
                                       index, file_name(of), numbered));
  TriangleMesh &front = parts.front().mesh, &first = parts[index].mesh;
  if (index > 0) {  // what is told of the whole file stands in its first part
    first.names_materials = front.names_materials;
    first.warnings.insert(first.warnings.end(), front.warnings.begin(), front.warnings.end());
  }
  if (!all_numbered && index + 1 == numbered)
    warn(of.where("shape_index"), fmt::format("'{}': as in Mitsuba the last part comes with this one", file_name(of)));
  else
    parts.resize(index + 1);
  parts.erase(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(index));
}

void MitsubaReader::obj_mesh(const Properties& of, Group& group) {
  const bool loads_materials = of.boolean("load_materials", true);
  if (version0()) return obj_parts(of, group, loads_materials);
  file_mesh(
      of, group, true, [](const SceneFiles::File& file, int) { return parse_obj(file.bytes, file.path, Polygons::fans); }, 0);
}

void MitsubaReader::obj_parts(const Properties& of, Group& group, bool loads_materials) {
  const SceneFiles::File file = read_file_of(of);
  const std::string title = "'" + of.string("filename", "") + "'";
  auto bsdfs = of.named_objects("bsdf");
  const auto parsed = [&](const auto& parse) {
    try {
      return parse();
    } catch (const Error& e) {
      throw Error(of.where("filename"), e.what());
    }
  };
  const bool apart = !of.boolean("collapse", false), takes_one = of.integer("shape_index", -1, -1, most_parts) >= 0;
  std::vector<ObjPart> parts = parsed([&] { return parse_obj_parts(file.bytes, file.path, apart); });
  if (takes_one) take_obj_part(of, file.bytes, parts);
  forget_names_of_no_part(of, parts, bsdfs);
  const bool by_name = std::ranges::any_of(bsdfs, is_named);
  const bool own = of.boolean("face_normals", false) ||
                   std::ranges::none_of(parts, [](const ObjPart& part) { return part.mesh.normals.empty(); });
  if (!by_name && own && !takes_one) {
    parts.clear();
    parts.push_back({"", parsed([&] { return parse_obj(file.bytes, file.path, Polygons::fans); })});
  }
  if (parts.size() > 1 && of.has_object({"emitter", "luminaire"}))
    throw Error(of.where(), fmt::format("{}: has {} parts, of which Mitsuba lets none emit light", of.title(), parts.size()));
  std::optional<std::uint32_t> otherwise;
  const bool has_own = loads_materials && parts.front().mesh.names_materials;
  std::map<std::string, std::size_t> last;  // place in `bsdfs`, by name
  for (std::size_t i = 0; i < bsdfs.size(); ++i) last[bsdfs[i].first] = i;
  for (ObjPart& part : parts) {
    finish_file_mesh(of, true, part.mesh);
    const auto of_all = last.find(""), of_name = last.find(part.material);
    const XmlElement* of_part = nullptr;
    for (const auto& found : {of_all, of_name})
      if (found != last.end() && (of_part == nullptr || found->second > of_all->second)) of_part = bsdfs[found->second].second;
    if (!of_part && !otherwise) {
      otherwise = default_material(of);
      if (has_own)
        warn(of.where("filename"),
             fmt::format("{}: the materials it names are not read: faces without a bsdf are grey, of lights black", title));
    }
    MaterialEntry& entry = materials_[of_part ? bsdf(*of_part) : *otherwise];
    if (const auto seen = look(of, group, entry, !part.mesh.uvs.empty()))
      place(std::move(part.mesh), of.transform("to_world"), *seen, of, group, title, false);
  }
}

// A single name that the file does not have is as good as none.
void MitsubaReader::forget_names_of_no_part(const Properties& of, std::span<const ObjPart> parts,
                                            std::vector<std::pair<std::string, const XmlElement*>>& bsdfs) {
  std::set<std::string_view> of_parts;
  for (const ObjPart& part : parts) of_parts.insert(part.material);
  for (auto& [name, element] : bsdfs) {
    if (name.empty() || of_parts.contains(name)) continue;
    const bool alone = bsdfs.size() == 1;
    warn(element->where(), fmt::format("no face of '{}' is of the material '{}', for which this bsdf is{}", file_name(of), name,
                                       alone ? ": Mitsuba's are grey, and here it is for all" : ""));
    if (alone) name.clear();
  }
}

}  // namespace etendue
