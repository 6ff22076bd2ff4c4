// Integrator, Sampler, PixelFilter and Accelerator: how pbrt itself would render, which the command line decides here. Each
// name and each parameter of versions 3 and 4 is known, and anything else an error: a misspelt "maxdepth" must not be lost. Of
// an integrator, the depth alone is kept; what else would change the image has a warning.

#include "framework/io/pbrt/reader.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>

namespace etendue {

namespace {

struct Known {
  std::string_view name;
  std::string_view parameters;  // "integer maxdepth, bool regularize!"; ! marks those that would change the image
  bool all_light = true;        // of an integrator: computes all transport, as the methods here do
};

constexpr Known integrators[] = {
    {"ambientocclusion", "bool cossample, float maxdistance, integer nsamples, integer pixelbounds!", false},
    {"ao", "bool cossample, float maxdistance, integer nsamples, integer pixelbounds!", false},
    {"bdpt",
     "integer maxdepth, bool regularize!, bool visualizestrategies!, bool visualizeweights!, string lightsamplestrategy, "
     "integer pixelbounds!"},
    {"directlighting", "integer maxdepth, string strategy, integer pixelbounds!", false},
    {"function", "string function, bool skipbad, string imagefilename", false},
    {"lightpath", "integer maxdepth"},
    {"mlt",
     "integer maxdepth, integer bootstrapsamples, integer chains, integer mutationsperpixel, float largestepprobability, "
     "float sigma, bool regularize!"},
    {"path",
     "integer maxdepth, string lightsampler, bool regularize!, float rrthreshold, string lightsamplestrategy, "
     "integer pixelbounds!"},
    {"randomwalk", "integer maxdepth"},
    {"simplepath", "integer maxdepth, bool samplebsdf, bool samplelights"},
    {"simplevolpath", "integer maxdepth"},
    {"sppm",
     "integer maxdepth, integer iterations, integer numiterations, integer photonsperiteration, integer imagewritefrequency, "
     "float radius, integer seed"},
    {"volpath",
     "integer maxdepth, string lightsampler, bool regularize!, float rrthreshold, string lightsamplestrategy, "
     "integer pixelbounds!"},
    {"whitted", "integer maxdepth, integer pixelbounds!", false},
};

// Version 3 has random, lowdiscrepancy and its other name, and maxmindist. Some of its scenes give pixelsamples to every
// sampler.
constexpr Known samplers[] = {
    {"02sequence", "integer pixelsamples, integer dimensions"},
    {"halton", "integer pixelsamples, integer seed, string randomization, bool samplepixelcenter"},
    {"independent", "integer pixelsamples, integer seed"},
    {"lowdiscrepancy", "integer pixelsamples, integer dimensions"},
    {"maxmindist", "integer pixelsamples, integer dimensions"},
    {"paddedsobol", "integer pixelsamples, integer seed, string randomization"},
    {"pmj02bn", "integer pixelsamples, integer seed"},
    {"random", "integer pixelsamples, integer seed"},
    {"sobol", "integer pixelsamples, integer seed, string randomization"},
    {"stratified", "integer xsamples, integer ysamples, bool jitter, integer seed, integer dimensions, integer pixelsamples"},
    {"zsobol", "integer pixelsamples, integer seed, string randomization"},
};

constexpr Known filters[] = {
    {"box", "float xradius, float yradius, float xwidth, float ywidth"},
    {"gaussian", "float xradius, float yradius, float xwidth, float ywidth, float sigma, float alpha"},
    {"mitchell", "float xradius, float yradius, float xwidth, float ywidth, float B, float C"},
    {"sinc", "float xradius, float yradius, float xwidth, float ywidth, float tau"},
    {"triangle", "float xradius, float yradius, float xwidth, float ywidth"},
};

constexpr Known accelerators[] = {
    {"bvh", "integer maxnodeprims, string splitmethod"},
    {"kdtree", "integer intersectcost, integer traversalcost, float emptybonus, integer maxprims, integer maxdepth"},
};

const Known& find_known(std::span<const Known> table, std::string_view kind, const std::string& name, const Location& where) {
  const auto found = std::find_if(table.begin(), table.end(), [&](const Known& k) { return k.name == name; });
  if (found != table.end()) return *found;
  std::vector<std::string> names;
  for (const Known& k : table) names.emplace_back(k.name);
  throw Error(where, unknown_name(kind, name, names));
}

// Calls `visit(type, name, changes_image)` for each parameter.
template <class Visit>
void for_known(std::string_view parameters, const Visit& visit) {
  for (WordReader words(parameters); !words.at_end();) {
    const std::string_view type = words.word();
    std::string_view name = words.word();
    if (name.ends_with(',')) name.remove_suffix(1);
    const bool changes_image = name.ends_with('!');
    if (changes_image) name.remove_suffix(1);
    visit(type, name, changes_image);
  }
}

}  // namespace

void PbrtReader::integrator(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "Integrator");
  const Known& known = find_known(integrators, "integrator", type, where);
  const PbrtParams params(lexer, titled(token.text, type), lexer.where(token), version3_);
  has_integrator_ = true;
  scene_.max_depth.reset();  // of an earlier integrator
  for_known(known.parameters, [&](std::string_view kind, std::string_view name, bool changes_image) {
    params.accept(name, kind);
    const bool given = params.has(name) && (kind != "bool" || params.boolean(name, false));
    if (given && changes_image) warn(params.where(name), fmt::format("Integrator: '{}' has no effect here", name));
    if (given && name == "maxdepth") scene_.max_depth = params.integer(name, 5, 0, 65536);
  });
  params.finish();
  of_pbrts_depth_.reset();
  if (known.all_light && !scene_.max_depth) of_pbrts_depth_ = where;
  direct_only_.reset();
  if (type == "directlighting" || type == "whitted")
    direct_only_ = DirectOnly{where, type};
  else if (!known.all_light)
    warn_of_part(where, type);
}

void PbrtReader::warn_of_part(const Location& where, const std::string& type) {
  warn(where, fmt::format("Integrator \"{}\" shows a part of the light in pbrt; here every method computes all of it", type));
}

// Light that is scattered once is all that such an integrator shows where nothing is specular: it follows what is.
void PbrtReader::limit_to_direct_light() {
  constexpr std::string_view depth = "pbrt ends paths after 5 scattering events; here after 64, or as max_depth says";
  if (!has_integrator_) warn({files_.first_file()}, fmt::format("without an Integrator {}", depth));
  if (of_pbrts_depth_) warn(*of_pbrts_depth_, fmt::format("Integrator: without 'maxdepth' {}", depth));
  if (!direct_only_) return;
  const auto& materials = scene_.materials;
  if (std::any_of(materials.begin(), materials.end(), [](const Material& m) { return has_specular(m); }))
    warn_of_part(direct_only_->where, direct_only_->type);
  else
    scene_.max_depth = 1;
}

void PbrtReader::sampler(PbrtLexer& lexer, const Token& token) { accept_known(lexer, token, "sampler"); }
void PbrtReader::accelerator(PbrtLexer& lexer, const Token& token) { accept_known(lexer, token, "accelerator"); }

void PbrtReader::accept_known(PbrtLexer& lexer, const Token& token, std::string_view kind) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, std::string(token.text));
  const Known& known =
      kind == "sampler" ? find_known(samplers, kind, type, where) : find_known(accelerators, kind, type, where);
  const PbrtParams params(lexer, titled(token.text, type), lexer.where(token), version3_);
  for_known(known.parameters, [&](std::string_view of, std::string_view name, bool) { params.accept(name, of); });
  params.finish();
}

void PbrtReader::pixel_filter(PbrtLexer& lexer, const Token& token) {
  const Location where = lexer.where(lexer.peek());
  const std::string type = expect_string(lexer, "PixelFilter");
  const Known& known = find_known(filters, "pixel filter", type, where);
  const PbrtParams params(lexer, titled(token.text, type), lexer.where(token), version3_);
  for_known(known.parameters, [&](std::string_view kind, std::string_view name, bool) { params.accept(name, kind); });
  constexpr float least = 0.01f, most = 32;
  FilterShape shape = named_filter(type);
  constexpr const char* names[2][2] = {{"xwidth", "xradius"}, {"ywidth", "yradius"}};
  for (int axis = 0; axis < 2; ++axis) {
    filter_by_version_[axis] = type == "gaussian" && !params.has(names[axis][0]) && !params.has(names[axis][1]);
    for (const char* name : names[axis]) shape.radius[axis] = params.number(name, shape.radius[axis], least, most);
  }
  if (params.has("alpha")) shape.sigma = 1 / std::sqrt(2 * params.number("alpha", 2, 1e-4f, 1e4f));
  if (type == "gaussian") shape.sigma = params.number("sigma", shape.sigma, 1e-2f, 100);
  if (type == "mitchell") {
    shape.b = params.number("B", shape.b, -10, 10);
    shape.c = params.number("C", shape.c, -10, 10);
  }
  if (type == "sinc") shape.tau = params.number("tau", shape.tau, 0.1f, 100);
  params.finish();
  filter_ = shape;
}

// Version 4 takes a Gaussian where there is no filter, and version 3 a box.
FilterShape PbrtReader::filter_of_version() const {
  if (!filter_) return version3_ ? FilterShape{} : named_filter("gaussian");
  FilterShape shape = *filter_;
  if (version3_) shape.radius = glm::mix(shape.radius, vec2(2), filter_by_version_);
  return shape;
}

}  // namespace etendue
