#include "experiments/report/page/images.h"

#include "experiments/report/report_text.h"
#include "framework/core/error.h"
#include "framework/core/parallel.h"
#include "framework/core/units.h"
#include "framework/image/metrics.h"
#include "framework/io/image/exr.h"
#include "framework/io/image/image_file.h"
#include "framework/io/image/png.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>

namespace etendue {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

// The viridis table has every sixteenth colour; others are linear between.
Rgb viridis(double t) {
  constexpr std::array table{0x440154, 0x481a6c, 0x472f7d, 0x414487, 0x39568c, 0x31688e, 0x2a788e, 0x23888e,
                             0x1f988b, 0x22a884, 0x35b779, 0x54c568, 0x7ad151, 0xa5db36, 0xd2e21b, 0xfde725};
  const double position = std::clamp(t, 0.0, 1.0) * (table.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(position), table.size() - 2);
  const double f = position - static_cast<double>(i);
  const auto channel = [&](int shift) {
    return static_cast<std::uint8_t>(std::lround((1 - f) * (table[i] >> shift & 0xff) + f * (table[i + 1] >> shift & 0xff)));
  };
  return {channel(16), channel(8), channel(0)};
}

ivec2 reduced_size(ivec2 size, int factor) { return (size + factor - 1) / factor; }

// Averages factor x factor blocks, and at the right and lower edge what is left.
template <class Value>
std::vector<Value> reduced(const std::vector<Value>& pixels, ivec2 size, int factor) {
  const ivec2 small = reduced_size(size, factor);
  std::vector<Value> sums(static_cast<std::size_t>(small.x) * small.y, Value(0));
  std::vector<int> counts(sums.size(), 0);
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      const std::size_t to = static_cast<std::size_t>(y / factor) * small.x + x / factor;
      sums[to] += pixels[static_cast<std::size_t>(y) * size.x + x];
      ++counts[to];
    }
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] /= static_cast<double>(counts[i]);
  return sums;
}

// Makes a PNG in base64.
template <class Value, class Colour>
std::string encode(const std::vector<Value>& pixels, ivec2 size, const Colour& colour) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3 * pixels.size());
  for (const Value& pixel : pixels)
    for (const std::uint8_t byte : colour(pixel)) bytes.push_back(byte);
  return base64(encode_png(bytes.data(), size));
}

struct Source {
  const Configuration* configuration;
  const Replicate* replicate;
};

// Chooses the image to show for each integrator of a scene.
std::vector<Source> choose(const SceneData& scene) {
  std::map<std::size_t, Source> chosen;
  for (const Configuration& configuration : scene.configurations)
    for (const Replicate& replicate : configuration.replicates)
      if (!replicate.cell->image.empty()) {
        chosen.try_emplace(configuration.integrator_index, Source{&configuration, &replicate});
        break;
      }
  std::vector<Source> result;
  for (const auto& [index, source] : chosen) result.push_back(source);
  return result;
}

std::optional<Image> try_read(const std::string& path) {
  try {
    return path.empty() ? std::nullopt : std::optional(read_exr(path));
  } catch (const Error&) {
    return std::nullopt;
  }
}

// White lies a quarter above the 98th percentile of the brightest channel: lamps in view do not darken the room, and an evenly
// lit scene is light grey, not white.
double exposure_for(const Image& image) {
  std::vector<double> values;
  values.reserve(image.pixels.size());
  for (const dvec3& p : image.pixels) values.push_back(std::max({p.x, p.y, p.z}));
  const double white = values.empty() ? 0 : 1.25 * quantile(values, 0.98);
  return white > 0 ? 1 / white : 1;
}

// What the colours of error maps span: nearly all errors above zero, in two decades at least and six at most.
std::pair<int, int> decades_of(const std::vector<std::vector<double>>& maps) {
  std::vector<double> all;
  for (const std::vector<double>& map : maps)
    std::ranges::copy_if(map, std::back_inserter(all), [](double error) { return error > 0; });
  const int high = all.empty() ? 0 : static_cast<int>(std::ceil(std::log10(quantile(all, 0.995))));
  const int low = all.empty() ? -1 : static_cast<int>(std::floor(std::log10(quantile(all, 0.05))));
  return {std::clamp(low, high - 6, high - 2), high};
}

std::string detail_of(const ReportData& data, const Source& source) {
  const CheckpointRecord& last = *source.replicate->last();
  std::string text = fmt::format("seed {}, {}, {}", source.replicate->seed, counted(last.iterations, "iteration"),
                                 format_seconds(last.time_s));
  if (const auto relmse = find_value(last.metrics, "relmse")) text += fmt::format(", relmse {}", format_figure(*relmse));
  if (data.accels.size() > 1) text += ", on " + source.configuration->shown_accel;
  return text;
}

SceneImages images_of(const ReportData& data, const SceneData& scene, int longest_side) {
  SceneImages result;
  result.scene = scene.name;
  const std::optional<Image> reference = try_read(scene.reference != nullptr ? scene.reference->file : std::string());
  const std::vector<Source> sources = choose(scene);
  std::vector<std::optional<Image>> images(sources.size());
  parallel_for(sources.size(), 1, [&](std::size_t i) { images[i] = try_read(sources[i].replicate->cell->image); });

  const Image* guide = reference ? &*reference : nullptr;
  std::vector<std::string> missing;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (guide == nullptr && images[i]) guide = &*images[i];
    if (images[i] && images[i]->size == guide->size) continue;
    missing.push_back(sources[i].configuration->shown_integrator);
    images[i].reset();
  }
  if (guide == nullptr) return result;
  const ivec2 size = guide->size;
  const int factor = std::max(1, (std::max(size.x, size.y) + longest_side - 1) / longest_side);
  result.shown = reduced_size(size, factor);

  std::vector<std::vector<double>> errors(images.size());
  for (std::size_t i = 0; i < images.size() && reference; ++i)
    if (images[i]) errors[i] = reduced(relative_squared_errors(*images[i], *reference), size, factor);
  std::tie(result.lowest_decade, result.highest_decade) = decades_of(errors);

  const double exposure = exposure_for(*guide);
  const auto picture = [&](const Image& image) {
    return encode(reduced(image.pixels, size, factor), result.shown, [&](const dvec3& pixel) {
      return Rgb{linear_to_srgb_byte(pixel.x * exposure), linear_to_srgb_byte(pixel.y * exposure),
                 linear_to_srgb_byte(pixel.z * exposure)};
    });
  };
  const auto error_map = [&](const std::vector<double>& map) {
    const double low = result.lowest_decade, span = result.highest_decade - low;
    return encode(map, result.shown, [&](double e) { return viridis(e > 0 ? (std::log10(e) - low) / span : 0); });
  };
  if (reference) result.images.push_back({"reference", scene.reference->source, picture(*reference), ""});
  std::vector<PageImage> encoded(images.size());
  parallel_for(images.size(), 1, [&](std::size_t i) {
    if (images[i])
      encoded[i] = {sources[i].configuration->short_integrator, detail_of(data, sources[i]), picture(*images[i]),
                    errors[i].empty() ? "" : error_map(errors[i]), find_value(sources[i].replicate->last()->metrics, "relmse")};
  });
  for (PageImage& image : encoded)
    if (!image.png.empty()) result.images.push_back(std::move(image));

  if (factor > 1)
    result.notes.push_back(fmt::format("Shown at {}×{} of {}×{} pixels: blocks of {}×{} are averaged, which hides noise.",
                                       result.shown.x, result.shown.y, size.x, size.y, factor, factor));
  if (data.accels.size() > 1) result.notes.push_back("One structure's image stands for all: structures change only the time.");
  if (!reference) result.notes.push_back("No image of the reference was kept, so there are no error maps.");
  for (const std::string& name : missing)
    result.notes.push_back(fmt::format("The image of {} is missing or of another size.", name));
  result.notes.push_back(
      fmt::format("White at 0 EV is {} W/(m² sr), 1.25 times the 98th percentile; what is brighter was clipped, so only "
                  "darker parts can be exposed anew.",
                  format_figure(1 / exposure)));
  return result;
}

}  // namespace

std::vector<SceneImages> page_images(const ReportData& data, std::size_t budget_bytes) {
  constexpr double bytes_per_pixel = 3.5;  // of noisy PNG in base64
  constexpr std::array sides{1024, 768, 512, 384, 256, 192, 128, 96};
  double pictures = 0;
  for (const SceneData& scene : data.scenes) pictures += 1 + 2 * static_cast<double>(choose(scene).size());
  const auto fits = [&](int side) {
    return pictures * side * side * 0.75 * bytes_per_pixel <= static_cast<double>(budget_bytes);
  };
  const auto longest = std::find_if(sides.begin(), std::prev(sides.end()), fits);
  std::vector<SceneImages> result;
  std::size_t used = 0, left_out = 0;
  for (const SceneData& scene : data.scenes) {
    if (choose(scene).empty()) continue;
    if (used > budget_bytes) {
      ++left_out;
      continue;
    }
    SceneImages images = images_of(data, scene, *longest);
    for (const PageImage& image : images.images) used += image.png.size() + image.error_png.size();
    if (!images.images.empty()) result.push_back(std::move(images));
  }
  if (left_out > 0 && !result.empty())
    result.back().notes.push_back(fmt::format("Images of {} more scenes are left out to keep this page small.", left_out));
  return result;
}

std::string viridis_css(double t) { return fmt::format("#{:02x}", fmt::join(viridis(t), "")); }

std::string viridis_stops() {
  std::vector<std::string> stops;
  for (int i = 0; i <= 10; ++i) stops.push_back(viridis_css(i / 10.0));
  return fmt::format("{}", fmt::join(stops, ","));
}

}  // namespace etendue
