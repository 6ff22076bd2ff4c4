// The colours of pbrt parameters: rgb, float, blackbody and spectrum, as RGB.

#include "framework/io/pbrt/params.h"
#include "framework/io/spectra.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace etendue {

namespace {

SampledSpectrum from_pairs(const std::vector<double>& numbers) {
  if (numbers.empty() || numbers.size() % 2 != 0)
    throw Error(fmt::format("expected pairs of wavelength and value, found {} numbers", numbers.size()));
  SampledSpectrum spectrum;
  for (std::size_t i = 0; i < numbers.size(); i += 2) {
    if (i > 0 && !(numbers[i] > numbers[i - 2]))
      throw Error(fmt::format("wavelengths must increase, but {} nm follows {} nm", numbers[i], numbers[i - 2]));
    if (!(numbers[i + 1] >= 0)) throw Error(fmt::format("the value {} at {} nm is negative", numbers[i + 1], numbers[i]));
    spectrum.wavelengths.push_back(numbers[i]);
    spectrum.values.push_back(numbers[i + 1]);
  }
  return spectrum;
}

// A text of wavelengths and values, with # comments.
SampledSpectrum parse_spectrum(std::string_view text, const std::string& path) {
  std::vector<double> numbers;
  for (WordReader words(text); !words.at_end(); words.next_line())
    for (std::string_view word = words.word(); !word.empty() && word.front() != '#'; word = words.word()) {
      const auto number = parse_number(word);
      if (!number)  // what the file may be instead is not for the message
        throw Error(location_at(path, text, words.offset() - word.size()), "no spectrum: expected a number");
      numbers.push_back(*number);
    }
  return from_pairs(numbers);
}

// In version 4 nothing lies beyond the ends. Indices go on there, for no surface has an index of 0.
Rgb to_rgb(const SampledSpectrum& spectrum, ColourUse use, bool version3) {
  if (version3) return version3_rgb(spectrum);
  if (use == ColourUse::light) return light_rgb(spectrum);
  return use == ColourUse::index ? surface_rgb(spectrum) : bounded_surface_rgb(spectrum);
}

// May the name be that of a metal's index?
bool may_be_index(ColourUse use) { return use == ColourUse::index || use == ColourUse::factor; }

std::optional<Rgb> metal_spectrum(std::string_view name) {
  for (const MetalIndex& metal : metals()) {
    if (name == fmt::format("metal-{}-eta", metal.name)) return metal.eta;
    if (name == fmt::format("metal-{}-k", metal.name)) return metal.k;
  }
  return std::nullopt;
}

// The correlated colour temperature of an illuminant that is not computed in full.
std::optional<double> illuminant_temperature(std::string_view name) {
  constexpr std::pair<std::string_view, double> temperatures[] = {
      {"stdillum-A", 2856},   {"stdillum-D50", 5003}, {"stdillum-D55", 5503}, {"stdillum-D75", 7504}, {"stdillum-F1", 6430},
      {"stdillum-F2", 4230},  {"stdillum-F3", 3450},  {"stdillum-F4", 2940},  {"stdillum-F5", 6350},  {"stdillum-F6", 4150},
      {"stdillum-F7", 6500},  {"stdillum-F8", 5000},  {"stdillum-F9", 4150},  {"stdillum-F10", 5000}, {"stdillum-F11", 4000},
      {"stdillum-F12", 3000}, {"illum-acesD60", 6000}};
  for (const auto& [known, kelvin] : temperatures)
    if (known == name) return kelvin;
  return std::nullopt;
}

std::vector<std::string> spectrum_names(ColourUse use) {
  std::vector<std::string> names;
  if (use == ColourUse::light) names.emplace_back("stdillum-D65");
  if (may_be_index(use))
    for (const MetalIndex& metal : metals()) {
      names.push_back(fmt::format("metal-{}-eta", metal.name));
      names.push_back(fmt::format("metal-{}-k", metal.name));
    }
  names.emplace_back("FILE.spd");
  return names;
}

}  // namespace

Rgb PbrtParams::spectrum_colour(const PbrtParam& param, ColourUse use) const {
  const bool is_file = param.strings.size() == 1 && param.numbers.empty() && param.strings[0].find('.') != std::string::npos;
  const SceneFiles::File file = is_file ? files_->read(param.strings[0], *file_, where(param.name)) : SceneFiles::File{};
  if (const auto kelvin = param.strings.size() == 1 ? illuminant_temperature(param.strings[0]) : std::nullopt;
      kelvin && param.numbers.empty() && use == ColourUse::light) {
    if (param.strings[0] != "stdillum-A")  // which is a blackbody
      files_->approximations().take(where(param.name), quote(param.strings[0]) + " is not supported in full",
                                    "a blackbody of its colour temperature");
    return blackbody_rgb(*kelvin);
  }
  try {
    if (is_file) return to_rgb(parse_spectrum(file.bytes, file.path), use, version3_);
    if (param.strings.empty()) return to_rgb(from_pairs(param.numbers), use, version3_);
    if (param.strings.size() != 1 || !param.numbers.empty()) throw Error("expected one name, or pairs of wavelength and value");
    const std::string& name = param.strings[0];
    if (use == ColourUse::light && name == "stdillum-D65") return Rgb(1);
    if (const auto metal = metal_spectrum(name); metal && may_be_index(use)) return *metal;
    throw Error(unknown_name("spectrum", name, spectrum_names(use)));
  } catch (const Error& e) {
    throw Error(where(param.name), fmt::format("{}: '{}': {}", owner_, param.name, e.what()));
  }
}

// One value: pbrt-v4, of luminance 1. Two, temperature and scale: pbrt-v3, of unit peak.
Rgb PbrtParams::blackbody_colour(const PbrtParam& param, ColourUse use) const {
  if (use != ColourUse::light) fail(param.name, "is a blackbody, which only lights can be");
  const std::vector<double>& n = param.numbers;
  if (n.size() != 1 && n.size() != 2) fail(param.name, "expected a temperature, or a temperature and a scale");
  if (!(n[0] >= 100 && n[0] <= 1e6)) fail(param.name, fmt::format("is {} K; expected 100 to 1e6", n[0]));
  return n.size() == 1 ? blackbody_rgb(n[0]) : static_cast<float>(n[1]) * blackbody_rgb_of_unit_peak(n[0]);
}

std::optional<Rgb> PbrtParams::colour(std::string_view name, ColourUse use) const {
  const PbrtParam* param =
      find_typed(name, {"rgb", "xyz", "float", "integer", "blackbody", "spectrum"}, "rgb, float, blackbody or spectrum");
  if (!param) return std::nullopt;
  if (version3_ && use != ColourUse::factor && is_number(name)) {
    files_->warn(where(name), fmt::format("{}: '{}' has no effect, as in pbrt-v3, which expects a colour", owner_, name));
    return std::nullopt;
  }
  Rgb colour;
  if (param->type == "spectrum") {
    colour = spectrum_colour(*param, use);
    if (use == ColourUse::reflectance && version3_ && max_component(colour) > 1) {
      files_->warn(where(name), fmt::format("'{}' is {:.4g} in a channel, under light of equal energy: clamped to 1", name,
                                            max_component(colour)));
      colour = glm::min(colour, Rgb(1));
    }
  } else if (param->type == "blackbody") {
    colour = blackbody_colour(*param, use);
  } else if (param->type == "rgb" || param->type == "xyz") {
    if (param->numbers.size() != 3) fail(name, fmt::format("has {} values; expected three", param->numbers.size()));
    colour = {param->numbers[0], param->numbers[1], param->numbers[2]};
    if (param->type == "xyz") colour = Rgb(glm::max(xyz_to_rgb(dvec3(colour)), dvec3(0)));
  } else {
    colour = Rgb(static_cast<float>(single(*param)));
    param->widened = param->type == "integer";
  }
  if (use == ColourUse::factor && is_number(name)) {  // relief may be turned inside out, and of any height
    if (!(std::abs(colour.x) <= 1e30f)) fail(name, fmt::format("is {}; expected -1e30 to 1e30", colour.x));
    return colour;
  }
  // Metals have indices of hundreds at most, in the far infrared.
  const float most = use == ColourUse::reflectance ? 1 : may_be_index(use) ? 1000 : 1e30f;
  if (use == ColourUse::reflectance && is_finite(colour) && glm::all(glm::greaterThanEqual(colour, Rgb(0))) &&
      max_component(colour) > 1 && files_->approximations().allowed()) {
    files_->approximations().take(where(name), "a reflectance above 1", "1, for no surface makes light: it is darker");
    colour = glm::min(colour, Rgb(1));
  }
  for (int c = 0; c < 3; ++c)
    if (!(colour[c] >= 0 && colour[c] <= most))
      fail(name, fmt::format("has the component {}; expected 0 to {:g}", colour[c], most));
  return colour;
}

}  // namespace etendue
