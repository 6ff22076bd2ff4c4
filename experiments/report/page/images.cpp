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
#include <map>

namespace etendue {
namespace {

// The viridis table at every sixteenth, linear between.
constexpr std::array<std::array<int, 3>, 16> viridis_table{{{68, 1, 84},
                                                            {72, 26, 108},
                                                            {71, 47, 125},
                                                            {65, 68, 135},
                                                            {57, 86, 140},
                                                            {49, 104, 142},
                                                            {42, 120, 142},
                                                            {35, 136, 142},
                                                            {31, 152, 139},
                                                            {34, 168, 132},
                                                            {53, 183, 121},
                                                            {84, 197, 104},
                                                            {122, 209, 81},
                                                            {165, 219, 54},
                                                            {210, 226, 27},
                                                            {253, 231, 37}}};

std::array<std::uint8_t, 3> viridis(double t) {
  const double position = std::clamp(t, 0.0, 1.0) * (viridis_table.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(position), viridis_table.size() - 2);
  const double f = position - static_cast<double>(i);
  std::array<std::uint8_t, 3> colour{};
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = static_cast<std::uint8_t>(std::lround((1 - f) * viridis_table[i][c] + f * viridis_table[i + 1][c]));
  return colour;
}

ivec2 reduced_size(ivec2 size, int factor) { return (size + factor - 1) / factor; }

// Averages of factor x factor blocks; at the right and lower edge of what is left.
template <class Value, class Get>
std::vector<Value> reduced(ivec2 size, int factor, const Get& get) {
  const ivec2 small = reduced_size(size, factor);
  std::vector<Value> sums(static_cast<std::size_t>(small.x) * small.y, Value(0));
  std::vector<int> counts(sums.size(), 0);
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      const std::size_t to = static_cast<std::size_t>(y / factor) * small.x + x / factor;
      sums[to] += get(static_cast<std::size_t>(y) * size.x + x);
      ++counts[to];
    }
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] /= static_cast<double>(counts[i]);
  return sums;
}

std::string encode_picture(const Image& image, int factor, double exposure) {
  const auto pixels = reduced<dvec3>(image.size, factor, [&](std::size_t i) { return image.pixels[i]; });
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3 * pixels.size());
  for (const dvec3& pixel : pixels)
    for (int c = 0; c < 3; ++c) bytes.push_back(linear_to_srgb_byte(pixel[c] * exposure));
  return base64(encode_png(bytes.data(), reduced_size(image.size, factor)));
}

std::string encode_errors(const std::vector<double>& errors, ivec2 size, int low, int high) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3 * errors.size());
  for (const double error : errors) {
    const double t = error > 0 ? (std::log10(error) - low) / (high - low) : 0;
    for (const std::uint8_t byte : viridis(t)) bytes.push_back(byte);
  }
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
  if (path.empty()) return std::nullopt;
  try {
    return read_exr(path);
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

std::string detail_of(const ReportData& data, const Source& source) {
  const CheckpointRecord& last = *source.replicate->last();
  std::string text = fmt::format("seed {}, {} iteration{}, {}", source.replicate->seed, last.iterations,
                                 last.iterations == 1 ? "" : "s", format_seconds(last.time_s));
  if (const auto found = last.metrics.find("relmse"); found != last.metrics.end())
    text += fmt::format(", relmse {}", format_figure(found->second));
  if (data.accels.size() > 1) text += ", on " + source.configuration->accel;
  return text;
}

constexpr double bytes_per_pixel = 3.5;  // of noisy PNG in base64

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
    if (!images[i] || images[i]->size != guide->size) missing.push_back(sources[i].configuration->integrator);
  }
  if (guide == nullptr) return result;
  result.original = guide->size;
  const int factor = std::max(1, (std::max(guide->size.x, guide->size.y) + longest_side - 1) / longest_side);
  result.shown = reduced_size(guide->size, factor);
  result.exposure = exposure_for(*guide);
  result.has_reference = reference.has_value();

  std::vector<std::vector<double>> errors(images.size());
  std::vector<double> all;
  for (std::size_t i = 0; i < images.size() && reference; ++i) {
    if (!images[i] || images[i]->size != guide->size) continue;
    const auto full = relative_squared_errors(*images[i], *reference);
    errors[i] = reduced<double>(guide->size, factor, [&](std::size_t k) { return full[k]; });
    for (const double error : errors[i])
      if (error > 0) all.push_back(error);
  }
  result.highest_decade = all.empty() ? 0 : static_cast<int>(std::ceil(std::log10(quantile(all, 0.995))));
  result.lowest_decade = all.empty() ? -1 : static_cast<int>(std::floor(std::log10(quantile(all, 0.05))));
  result.lowest_decade = std::clamp(result.lowest_decade, result.highest_decade - 6, result.highest_decade - 2);

  if (reference)
    result.images.push_back({"reference", scene.reference->source, encode_picture(*reference, factor, result.exposure), ""});
  std::vector<PageImage> encoded(images.size());
  parallel_for(images.size(), 1, [&](std::size_t i) {
    if (!images[i] || images[i]->size != guide->size) return;
    encoded[i] = {sources[i].configuration->integrator, detail_of(data, sources[i]),
                  encode_picture(*images[i], factor, result.exposure),
                  errors[i].empty() ? "" : encode_errors(errors[i], result.shown, result.lowest_decade, result.highest_decade)};
    const auto& last_metrics = sources[i].replicate->last()->metrics;
    if (const auto found = last_metrics.find("relmse"); found != last_metrics.end()) encoded[i].relmse = found->second;
  });
  for (PageImage& image : encoded)
    if (!image.png.empty()) result.images.push_back(std::move(image));

  if (factor > 1)
    result.notes.push_back(fmt::format("Shown at {}×{} of {}×{} pixels: blocks of {}×{} are averaged, which hides noise.",
                                       result.shown.x, result.shown.y, result.original.x, result.original.y, factor, factor));
  if (data.accels.size() > 1) result.notes.push_back("One structure's image stands for all: structures change only the time.");
  if (!reference) result.notes.push_back("No image of the reference was kept, so there are no error maps.");
  for (const std::string& name : missing)
    result.notes.push_back(fmt::format("The image of {} is missing or of another size.", name));
  return result;
}

}  // namespace

std::vector<SceneImages> page_images(const ReportData& data, std::size_t budget_bytes) {
  constexpr std::array<int, 8> sides{1024, 768, 512, 384, 256, 192, 128, 96};
  double pictures = 0;
  for (const SceneData& scene : data.scenes) pictures += 1 + 2 * static_cast<double>(choose(scene).size());
  int longest = sides.back();
  for (const int side : sides)
    if (pictures * side * side * 0.75 * bytes_per_pixel <= static_cast<double>(budget_bytes)) {
      longest = side;
      break;
    }
  std::vector<SceneImages> result;
  std::size_t used = 0, left_out = 0;
  for (const SceneData& scene : data.scenes) {
    if (choose(scene).empty()) continue;
    if (used > budget_bytes) {
      ++left_out;
      continue;
    }
    SceneImages images = images_of(data, scene, longest);
    for (const PageImage& image : images.images) used += image.png.size() + image.error_png.size();
    if (!images.images.empty()) result.push_back(std::move(images));
  }
  if (left_out > 0 && !result.empty())
    result.back().notes.push_back(fmt::format("Images of {} more scenes are left out to keep this page small.", left_out));
  return result;
}

std::string viridis_css(double t) {
  const auto colour = viridis(t);
  return fmt::format("#{:02x}{:02x}{:02x}", colour[0], colour[1], colour[2]);
}

}  // namespace etendue
