// Colours: rgb, srgb, spectrum and blackbody, as the linear RGB of Mitsuba's RGB modes. A spectrum of wavelengths is seen
// under light of equal energy, which Mitsuba before version 2 takes for surfaces too; later versions see those under D65.

#include "framework/core/elementary.h"
#include "framework/io/mitsuba/reader.h"
#include "framework/io/spectra.h"
#include "framework/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace etendue {

namespace {

constexpr std::string_view spectrum_types[] = {"uniform", "rawconstant", "d65",     "srgb",
                                               "rgb",     "blackbody",   "regular", "irregular"};

float decoded(float encoded) { return encoded <= 0.04045f ? encoded / 12.92f : math::pow((encoded + 0.055f) / 1.055f, 2.4f); }

Rgb decoded(const Rgb& c) { return {decoded(c.x), decoded(c.y), decoded(c.z)}; }

// "#rrggbb", as it stands
Rgb hexadecimal(const XmlElement& element) {
  const std::string text = element.value("value");
  const bool digits = text.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos;
  if (text.size() != 7 || !digits)
    throw Error(element.where("value"), fmt::format("{}: {}; expected #rrggbb", element.tag, quote(text)));
  Rgb c;
  for (int i = 0; i < 3; ++i)
    c[i] = static_cast<float>(std::stoi(text.substr(1 + 2 * static_cast<std::size_t>(i), 2), nullptr, 16)) / 255;
  return c;
}

Rgb triple(const XmlElement& element, std::string_view attribute) {
  const std::vector<float> n = read_numbers(element, attribute);
  if (n.size() == 1) return Rgb(n[0]);
  if (n.size() != 3)
    throw Error(element.where(attribute), fmt::format("{}: expected one number or three, found {}", element.tag, n.size()));
  return {n[0], n[1], n[2]};
}

SampledSpectrum checked(SampledSpectrum spectrum, const Location& where) {
  if (spectrum.values.empty()) throw Error(where, "spectrum: has no values");
  for (std::size_t i = 1; i < spectrum.wavelengths.size(); ++i)
    if (!(spectrum.wavelengths[i] > spectrum.wavelengths[i - 1]))
      throw Error(where, fmt::format("spectrum: wavelengths must increase, but {} nm follows {} nm", spectrum.wavelengths[i],
                                     spectrum.wavelengths[i - 1]));
  return spectrum;
}

// "400:0.3, 500:0.5"
SampledSpectrum wavelength_list(const XmlElement& element) {
  std::string text = element.value("value");
  for (char& c : text)
    if (c == ',') c = '\n';
  SampledSpectrum spectrum;
  WordReader words(text);
  for (std::string_view word = words.word_on_any_line(); !word.empty(); word = words.word_on_any_line()) {
    const std::size_t colon = word.find(':');
    const auto wavelength = parse_number(word.substr(0, colon));
    std::string_view rest = colon == std::string_view::npos ? std::string_view() : word.substr(colon + 1);
    if (rest.empty() && colon != std::string_view::npos) rest = words.word_on_any_line();  // "400: 0.3"
    const auto value = parse_number(rest);
    if (!wavelength || !value)
      throw Error(element.where("value"),
                  fmt::format("spectrum: {}; expected wavelength:value pairs, or one number", quote(word)));
    spectrum.wavelengths.push_back(*wavelength);
    spectrum.values.push_back(*value);
  }
  return checked(std::move(spectrum), element.where("value"));
}

SampledSpectrum spectrum_file(const SceneFiles::File& file) {
  SampledSpectrum spectrum;
  for (WordReader words(file.bytes); !words.at_end(); words.next_line()) {
    const std::string_view first = words.word();
    if (first.empty() || first.front() == '#') continue;
    const auto wavelength = parse_number(first), value = parse_number(words.word());
    if (!wavelength || !value)  // what the file may be instead is not for the message
      throw Error(location_at(file.path, file.bytes, words.offset()), "no spectrum: expected a wavelength and a value");
    spectrum.wavelengths.push_back(*wavelength);
    spectrum.values.push_back(*value);
  }
  return checked(std::move(spectrum), {file.path});
}

}  // namespace

// A texture may be a spectrum, by its type.
bool MitsubaReader::is_colour(const XmlElement& element) {
  if (element.tag == "texture") return std::ranges::find(spectrum_types, element.value("type")) != std::end(spectrum_types);
  return element.tag == "rgb" || element.tag == "srgb" || element.tag == "spectrum" || element.tag == "blackbody" ||
         element.tag == "float" || element.tag == "integer";
}

Rgb MitsubaReader::read_spectrum(const XmlElement& element, ColourUse use) {
  if (!element.value("type").empty()) return spectrum_object(element, use);
  SampledSpectrum spectrum;
  if (const std::string file = element.value("filename"); !file.empty())
    spectrum = spectrum_file(files_.read(file, tree_.looked_for_beside(file, *element.file), element.where("filename")));
  else if (element.value("value").find(':') == std::string::npos)
    return triple(element, "value");
  else
    spectrum = wavelength_list(element);
  // A metal's index is that of its reflectance under white light.
  const bool of_surface = use == ColourUse::index || (use != ColourUse::light && !version0());
  return of_surface ? surface_rgb(spectrum) : equal_energy_rgb(spectrum);
}

// Version 3's spectra with a type.
Rgb MitsubaReader::spectrum_object(const XmlElement& element, ColourUse use) {
  const Properties of = properties(element);
  const std::string& type = of.type();
  Rgb value(1);
  if (type == "uniform" || type == "rawconstant") {
    value = Rgb(of.number("value", 1));
    of.ignore({"wavelength_min", "wavelength_max", "lambda_min", "lambda_max"});
  } else if (type == "d65") {
    const XmlElement* tint = of.element("color");
    value = of.number("scale", 1) * (tint ? read_colour(*tint, use) : Rgb(1));
  } else if (type == "srgb" || type == "rgb") {
    const XmlElement* tint = of.element("color");
    if (!tint) throw Error(of.where(), fmt::format("{}: 'color' is missing", of.title()));
    value = read_colour(*tint, use);
  } else if (type == "blackbody") {
    value = of.number("scale", 1) * blackbody_radiance_rgb(of.number("temperature", 5000, 100, 1e6f));
  } else if (type == "regular" || type == "irregular") {
    SampledSpectrum spectrum;
    const XmlElement* values = of.element("values");
    if (!values) throw Error(of.where(), fmt::format("{}: 'values' is missing", of.title()));
    for (const float v : read_numbers(*values, "value")) spectrum.values.push_back(v);
    if (const XmlElement* wavelengths = of.element("wavelengths")) {
      for (const float w : read_numbers(*wavelengths, "value")) spectrum.wavelengths.push_back(w);
    } else {
      const double low = of.number("wavelength_min", of.number("lambda_min", 360)),
                   high = of.number("wavelength_max", of.number("lambda_max", 830));
      const double steps = std::max(1.0, static_cast<double>(spectrum.values.size()) - 1);
      for (std::size_t i = 0; i < spectrum.values.size(); ++i)
        spectrum.wavelengths.push_back(low + (high - low) * static_cast<double>(i) / steps);
    }
    if (spectrum.wavelengths.size() != spectrum.values.size())
      of.fail("values",
              fmt::format("has {} numbers, but there are {} wavelengths", spectrum.values.size(), spectrum.wavelengths.size()));
    spectrum = checked(std::move(spectrum), of.where());
    value = use == ColourUse::light ? equal_energy_rgb(spectrum) : surface_rgb(spectrum);
  } else {
    throw Error(element.where("type"),
                unknown_name("spectrum", type, std::vector<std::string>(std::begin(spectrum_types), std::end(spectrum_types))));
  }
  of.finish();
  return value;
}

float MitsubaReader::limit_of_reflectance(const Location& where, std::string_view what, float most) {
  constexpr float rounding = 1e-4f;
  if (!(most > 1 + rounding)) return 1;
  const std::string told = fmt::format("{}: reaches {:.4g}, more than a surface can reflect", what, most);
  const std::string scaled = "scaled to reach 0.99";
  if (!version0())
    warn(where, told + ": clamped to 1");
  else if (conserves_energy_)
    warn(where, told + ": " + scaled + ", as Mitsuba does");
  else
    approximate(where, told + "; ensureEnergyConservation is false", scaled);
  return version0() ? 0.99f / most : 1;
}

Rgb MitsubaReader::read_colour(const XmlElement& element, ColourUse use) {
  Rgb colour;
  if (element.tag == "blackbody") {
    std::string kelvin = element.value("temperature");
    if (kelvin.ends_with('K') || kelvin.ends_with('k')) kelvin.pop_back();
    const auto number = parse_number(kelvin);
    if (!number || !(*number >= 100 && *number <= 1e6))
      throw Error(element.where("temperature"),
                  fmt::format("blackbody: temperature {}; expected 100 to 1e6, in kelvin", quote(kelvin)));
    colour = (element.find("scale") ? read_number(element, "scale") : 1) * blackbody_radiance_rgb(*number);
  } else if (element.tag == "spectrum" || element.tag == "texture") {
    colour = read_spectrum(element, use);
  } else if (element.value("value").starts_with('#')) {
    colour = hexadecimal(element);
  } else {
    colour = triple(element, "value");
  }
  if (element.tag == "srgb") colour = decoded(colour);
  const float most = use == ColourUse::light || use == ColourUse::factor ? 1e12f : use == ColourUse::index ? 1000 : 1;
  if (use == ColourUse::reflectance && max_component(colour) > 1)
    colour = glm::min(limit_of_reflectance(element.where(), element.tag, max_component(colour)) * colour, Rgb(1));
  for (int c = 0; c < 3; ++c)
    if (!(colour[c] >= 0 && colour[c] <= most))
      throw Error(element.where(), fmt::format("{}: has the component {}; expected 0 to {:g}", element.tag, colour[c], most));
  return colour;
}

}  // namespace etendue
