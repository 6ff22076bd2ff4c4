#include "experiments/report/page/images.h"

#include "experiments/report/paper/comparison.h"
#include "experiments/report/report_text.h"
#include "framework/core/check.h"
#include "framework/core/error.h"
#include "framework/core/parallel.h"
#include "framework/core/units.h"
#include "framework/image/flip.h"
#include "framework/image/metrics.h"
#include "framework/io/image/exr.h"

#include <Imath/half.h>
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iterator>

namespace etendue {
namespace {

namespace fs = std::filesystem;

// A tone-mapped PNG in base64, `longest` pixels long at most.
std::string thumbnail(const Image& image, double white) {
  constexpr int longest = 144;
  const int factor = std::max(1, (std::max(image.size.x, image.size.y) + longest - 1) / longest);
  const std::string png = picture_of(image, {{0, 0}, image.size}, (image.size + factor - 1) / factor, 1 / white).png();
  return base64(std::vector<std::uint8_t>(png.begin(), png.end()));
}

std::optional<Image> try_read(const std::string& path) {
  try {
    return path.empty() ? std::nullopt : std::optional(read_exr(path));
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::string detail_of(const ReportData& data, const KeptImage& source) {
  const CheckpointRecord& last = *source.replicate->last();
  std::string text = fmt::format("seed {}, {}, {}", source.replicate->seed, counted(last.iterations, "iteration"),
                                 format_seconds(last.time_s));
  if (const auto relmse = find_value(last.metrics, "relmse")) text += fmt::format(", relmse {}", format_figure(*relmse));
  if (data.accels.size() > 1) text += ", on " + source.configuration->shown_accel;
  return text;
}

// --- what the colours of maps span ---

using ErrorOf = double (*)(double difference, double reference);
const std::map<std::string, ErrorOf> map_kinds{
    {"relative", [](double d, double r) { return d * d / (r * r + relmse_epsilon); }},
    {"squared", [](double d, double) { return d * d; }},
    {"absolute", [](double d, double) { return std::abs(d); }},
    {"symmetric", [](double d, double r) { return d == 0 ? 0 : std::abs(d) / (std::abs(d + r) + std::abs(r)); }},
    {"signed", [](double d, double) { return d; }}};

// Collects errors of a kind over all images; of many pixels some.
std::vector<double> sampled_errors(const std::vector<const Image*>& images, const Image& reference, ErrorOf error) {
  constexpr std::size_t most = 20000;
  const std::size_t stride = reference.pixels.size() / most + 1;
  std::vector<double> errors;
  for (const Image* image : images)
    for (std::size_t i = 0; i < reference.pixels.size(); i += stride) {
      const dvec3 x = image->pixels[i], r = reference.pixels[i];
      errors.push_back((error(x.x - r.x, r.x) + error(x.y - r.y, r.y) + error(x.z - r.z, r.z)) / 3);
    }
  return errors;
}

// Spans nearly all errors above zero, in two decades at least and six at most.
std::pair<double, double> decades_of(std::vector<double> errors) {
  std::erase_if(errors, [](double error) { return !(error > 0); });
  const double high = errors.empty() ? 0 : std::ceil(std::log10(quantile(errors, 0.995)));
  const double low = errors.empty() ? -1 : std::floor(std::log10(quantile(errors, 0.05)));
  return {std::clamp(low, high - 6, high - 2), high};
}

std::pair<double, double> symmetric_range(std::vector<double> errors) {
  for (double& error : errors) error = std::abs(error);
  const double most = errors.empty() ? 0 : quantile(errors, 0.97);
  const double end = most > 0 ? round_up_nicely(most) : 1;
  return {-end, end};
}

// --- pixels ---

// Encodes FLIP of each pixel; empty where it has no value, because a pixel is not finite.
std::string encode_flip(const Image& image, const Image& reference) {
  try {
    return encode_halves(flip_errors(image, reference), image.size);
  } catch (const Error&) {
    return {};
  }
}

// Keeps what fits in the page, and the rest beside it.
class PixelStore {
 public:
  explicit PixelStore(const ImagePlace& place) : place_(place) {}

  PixelText store(std::string text, const std::string& name) {
    if (used_ + text.size() <= place_.budget_bytes || !place_.write_beside) {
      used_ += text.size();
      return {std::move(text), {}};
    }
    const std::string file = "viewer/" + name + ".js";
    place_.write_beside(file, fmt::format("pixelData(\"{}\", \"{}\")\n", file, text));
    return {{}, file};
  }
  // Stores what was encoded for the page.
  void settle(PixelText& text, const std::string& name) {
    if (!text.in_page.empty()) text = store(std::move(text.in_page), name);
  }
  std::string link(const std::string& path) const {
    return fs::path(path)
        .lexically_relative(place_.directory.empty() ? fs::path() : fs::path(place_.directory).lexically_normal())
        .generic_string();
  }

 private:
  const ImagePlace& place_;
  std::size_t used_ = 0;
};

std::vector<dvec3> differences(const Image& image, const Image& reference) {
  std::vector<dvec3> result(image.pixels.size());
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = image.pixels[i] - reference.pixels[i];
  return result;
}

// Half-floats of an image and its reference have a relative error of up to 2⁻¹¹ each, which shows where the two nearly agree.
bool loses_difference(const Image& image, const Image& reference, double unit) {
  double exact = 0, rounded = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double x = image.pixels[i][c], r = reference.pixels[i][c];
      exact += map_kinds.at("relative")(x - r, r);
      rounded += map_kinds.at("relative")(rounded_to_half(x, unit) - rounded_to_half(r, unit), r);
    }
  return !(std::abs(rounded - exact) <= 0.01 * exact);
}

// The power of two at or below `value`, which is positive.
double power_of_two(double value) { return std::exp2(std::floor(std::log2(value))); }

// A unit that makes the largest difference a half-float of some thousands.
double difference_unit_of(const std::vector<dvec3>& values) {
  double most = 0;
  for (const dvec3& value : values) most = std::max({most, std::abs(value.x), std::abs(value.y), std::abs(value.z)});
  return most > 0 && std::isfinite(most) ? power_of_two(most) / 4096 : 1;
}

// The images at checkpoints lie one below the other in one file. `perceived`: the reference of FLIP; null: no FLIP.
void add_frames(PageImage& image, const KeptImage& source, const SceneImages& scene, const Image* perceived,
                const std::string& name, PixelStore& store) {
  const auto& checkpoints = source.replicate->checkpoints;
  const std::optional<Image> strip = try_read(source.replicate->cell->strip);
  if (!strip || strip->size != ivec2(scene.size.x, scene.size.y * static_cast<int>(checkpoints.size()))) return;
  const auto pixels = static_cast<std::ptrdiff_t>(scene.size.x) * scene.size.y;
  for (std::size_t i = 0; i < checkpoints.size(); ++i) {
    const auto first = strip->pixels.begin() + static_cast<std::ptrdiff_t>(i) * pixels;
    Image frame;
    frame.size = scene.size;
    frame.pixels.assign(first, first + pixels);
    const std::string file = fmt::format("{}-at-{}", name, i);
    image.frames.push_back({checkpoints[i]->time_s, store.store(encode_halves(frame.pixels, scene.size, scene.unit), file)});
    if (perceived != nullptr) image.frames.back().flip = store.store(encode_flip(frame, *perceived), file + "-flip");
  }
}

SceneImages images_of(const ReportData& data, const SceneData& scene, PixelStore& store) {
  SceneImages result;
  result.scene = scene.name;
  const std::string reference_file = scene.reference != nullptr ? scene.reference->file : std::string();
  const std::optional<Image> reference = try_read(reference_file);
  const std::vector<KeptImage> sources = kept_images(scene);
  std::vector<std::optional<Image>> images(sources.size());
  parallel_for(sources.size(), 1, [&](std::size_t i) { images[i] = try_read(sources[i].replicate->cell->image); });

  const Image* guide = reference ? &*reference : nullptr;
  std::vector<std::string> missing;
  std::vector<const Image*> shown;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (guide == nullptr && images[i]) guide = &*images[i];
    if (images[i] && images[i]->size == guide->size) {
      shown.push_back(&*images[i]);
      continue;
    }
    missing.push_back(sources[i].configuration->shown_integrator);
    images[i].reset();
  }
  if (guide == nullptr) return result;
  result.size = guide->size;
  result.white = white_of(*guide);
  result.unit = power_of_two(result.white);
  for (const auto& [kind, error] : map_kinds)
    if (reference) {
      std::vector<double> errors = sampled_errors(shown, *reference, error);
      result.ranges[kind] = kind == "signed" ? symmetric_range(std::move(errors)) : decades_of(std::move(errors));
    }
  const Image* perceived = reference && contains(data.metrics, "flip") ? &*reference : nullptr;
  if (perceived != nullptr) result.ranges["flip"] = {0, 1};

  std::vector<PageImage> encoded(images.size());
  parallel_for(images.size(), 1, [&](std::size_t i) {
    if (!images[i]) return;
    encoded[i].thumbnail = thumbnail(*images[i], result.white);
    encoded[i].pixels.in_page = encode_halves(images[i]->pixels, result.size, result.unit);
    if (perceived != nullptr) encoded[i].flip.in_page = encode_flip(*images[i], *perceived);
    if (!reference || !loses_difference(*images[i], *reference, result.unit)) return;
    const std::vector<dvec3> values = differences(*images[i], *reference);
    encoded[i].difference_unit = difference_unit_of(values);
    encoded[i].difference.in_page = encode_halves(values, result.size, encoded[i].difference_unit);
  });
  const auto name = [&](std::size_t i) { return fmt::format("{}-{}", scene.file_stem, i); };
  if (reference) {
    PageImage& image = result.images.emplace_back(PageImage{"reference", scene.reference->source});
    image.thumbnail = thumbnail(*reference, result.white);
    image.pixels = store.store(encode_halves(reference->pixels, result.size, result.unit), scene.file_stem + "-reference");
    image.exr = store.link(reference_file);
  }
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (!images[i]) continue;
    const auto& [configuration, replicate] = sources[i];
    PageImage& image = result.images.emplace_back(std::move(encoded[i]));
    image.label = configuration->short_integrator;
    image.detail = detail_of(data, sources[i]);
    image.configuration = configuration;
    store.settle(image.pixels, name(i));
    store.settle(image.difference, name(i) + "-difference");
    store.settle(image.flip, name(i) + "-flip");
    image.exr = store.link(replicate->cell->image);
    image.relmse = find_value(replicate->last()->metrics, "relmse");
    add_frames(image, sources[i], result, perceived, name(i), store);
  }

  if (data.accels.size() > 1) result.notes.push_back("One structure's image stands for all: structures change only the time.");
  if (!reference) result.notes.push_back("No image of the reference was kept, so there are no error maps.");
  for (const std::string& absent : missing)
    result.notes.push_back(fmt::format("The image of {} is missing or of another size.", absent));
  result.notes.push_back(fmt::format(
      "White at 0 EV is {} W/(m² sr), 1.25 times the 98th percentile. Pixels are half-floats, of 11 significant bits.",
      format_figure(result.white)));
  return result;
}

}  // namespace

std::vector<SceneImages> page_images(const ReportData& data, const ImagePlace& place) {
  PixelStore store(place);
  std::vector<SceneImages> result;
  for (const SceneData& scene : data.scenes) {
    if (kept_images(scene).empty()) continue;
    if (SceneImages images = images_of(data, scene, store); !images.images.empty()) result.push_back(std::move(images));
  }
  return result;
}

std::string colour_among(std::span<const int> colours, double t) {
  const double position = std::clamp(t, 0.0, 1.0) * static_cast<double>(colours.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(position), colours.size() - 2);
  const double f = position - static_cast<double>(i);
  const auto channel = [&](int shift) {
    return std::lround((1 - f) * (colours[i] >> shift & 0xff) + f * (colours[i + 1] >> shift & 0xff));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", channel(16), channel(8), channel(0));
}

std::vector<std::string> viridis_stops() {
  // Every sixteenth colour; others are linear between.
  constexpr std::array table{0x440154, 0x481a6c, 0x472f7d, 0x414487, 0x39568c, 0x31688e, 0x2a788e, 0x23888e,
                             0x1f988b, 0x22a884, 0x35b779, 0x54c568, 0x7ad151, 0xa5db36, 0xd2e21b, 0xfde725};
  return mapped(std::views::iota(0, 11), [&](int i) { return colour_among(table, i / 10.0); });
}

namespace {

half to_half(double value, double unit) {
  return half(static_cast<float>(std::clamp(value / unit, -static_cast<double>(HALF_MAX), static_cast<double>(HALF_MAX))));
}

// `value`(pixel, channel) of each pixel and of so many channels.
template <class Value>
std::string encode_planes(ivec2 size, int channels, double unit, const Value& value) {
  const std::size_t pixels = static_cast<std::size_t>(size.x) * size.y, count = static_cast<std::size_t>(channels) * pixels;
  std::vector<std::uint8_t> bytes(2 * count);
  for (int channel = 0; channel < channels; ++channel) {
    std::uint16_t before = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      if (i % static_cast<std::size_t>(size.x) == 0) before = 0;
      const std::uint16_t bits = to_half(value(i, channel), unit).bits();
      const auto difference = static_cast<std::uint16_t>(bits - before);
      const std::size_t at = static_cast<std::size_t>(channel) * pixels + i;
      bytes[at] = static_cast<std::uint8_t>(difference >> 8);
      bytes[count + at] = static_cast<std::uint8_t>(difference & 0xff);
      before = bits;
    }
  }
  uLongf length = compressBound(bytes.size());
  std::vector<std::uint8_t> packed(length);
  CHECK_EQ(compress2(packed.data(), &length, bytes.data(), bytes.size(), 6), Z_OK);
  packed.resize(length);
  return base64(packed);
}

}  // namespace

double rounded_to_half(double value, double unit) {
  return static_cast<double>(static_cast<float>(to_half(value, unit))) * unit;
}

std::string encode_halves(const std::vector<dvec3>& pixels, ivec2 size, double unit) {
  CHECK_EQ(pixels.size(), static_cast<std::size_t>(size.x) * size.y);
  return encode_planes(size, 3, unit, [&](std::size_t pixel, int channel) { return pixels[pixel][channel]; });
}

std::string encode_halves(const std::vector<double>& values, ivec2 size) {
  CHECK_EQ(values.size(), static_cast<std::size_t>(size.x) * size.y);
  return encode_planes(size, 1, 1, [&](std::size_t pixel, int) { return values[pixel]; });
}

}  // namespace etendue
