// The output of `etendue render`: the image and what goes beside it, and its figures on standard output.
#include "experiments/command/console.h"
#include "experiments/command/rendering.h"
#include "experiments/log/json_line.h"
#include "framework/core/units.h"
#include "framework/io/image/exr.h"
#include "framework/io/image/png.h"

#include <fmt/format.h>
#include <exception>
#include <filesystem>

namespace etendue {

namespace {

Image draw_aov(const std::string& aov, Integrator& integrator, const RenderContext& context, const Image& image) {
  if (is_surface_image(aov)) return draw_surface_image(aov, context);
  return aov == records_aov ? draw_records(image, context, integrator.cache()->record_shapes())
                            : integrator.cache()->standard_error();
}

void write_image(const Rendering& r, const CellResult& result, const std::string& path, const Image& image,
                 const std::string& aov = "") {
  if (path.ends_with(".png")) {
    write_png(path, image);
    return;
  }
  Recipe made = r;
  made.integrator = result.chosen.value_or(r.integrator);
  made.accel = result.chosen_accel.value_or(r.accel);
  made.iterations = result.checkpoints.back().iterations;
  made.pixel_filter = r.reading.pixel_filter;
  auto attributes = recipe_attributes(made, make_manifest("", "", r.threads));
  attributes["etendue_cell"] = CellName{r.scene, r.accel.label(), r.integrator.label(), r.seed}.key();
  if (!aov.empty()) attributes["etendue_aov"] = aov;
  write_exr(path, image, attributes);
}

}  // namespace

std::string aov_path(const std::string& output, const std::string& aov) {
  return std::filesystem::path(output).replace_extension(aov).string() +
         (is_surface_image(aov) ? ".exr" : std::filesystem::path(output).extension().string());
}

void write_outputs(const Rendering& r, Integrator& integrator, const RenderContext& context, const CellResult& result) {
  std::exception_ptr failure;
  const auto attempt = [&](const auto& write) {
    try {
      write();
    } catch (const std::exception&) {
      if (!failure) failure = std::current_exception();
    }
  };
  if (!r.output.empty()) attempt([&] { write_image(r, result, r.output, result.image); });
  exit_on_interrupt("\ninterrupted\n");
  if (!r.command.save_cache.empty())
    attempt([&] { write_whole_file(r.command.save_cache, integrator.cache()->save(context)); });
  for (const std::string& aov : r.command.aovs)
    attempt([&] {
      write_image(r, result, aov_path(r.output, aov), r.shown(draw_aov(aov, integrator, context, result.image)), aov);
    });
  if (failure) std::rethrow_exception(failure);
}

std::string to_json(const Rendering& r) {
  const CheckpointRecord& end = r.result.checkpoints.back();
  Json json{
      {"scene", r.scene},
      {"integrator", r.integrator.label()},
      {"accel", r.accel.label()},
      {"seed", r.seed},
      {"width", r.result.image.size.x},
      {"height", r.result.image.size.y},
      {"threads", r.threads},
      {"image", r.output},
      {"image_hash", fmt::format("{:016x}", r.result.image_hash)},
      {"spp", end.iterations},
      {"time_s", end.time_s},
      {"cpu_s", end.cpu_s},
      {"phases_s", end.phases_s},
      {"counters", end.counters},
      {"peak_memory_bytes", end.peak_memory_bytes},
      {"non_finite", end.non_finite},
      {"expectation", {{"bias", bias_name(r.result.expectation.bias)}, {"mse_exponent", r.result.expectation.mse_exponent}}}};
  for (const NonFiniteSample& sample : r.result.non_finite)
    json["non_finite_at"].push_back({sample.pixel.x, sample.pixel.y, sample.iteration});
  if (!r.warnings.empty()) json["warnings"] = r.warnings;
  for (const std::string& aov : r.command.aovs) json["aovs"][aov] = aov_path(r.output, aov);
  if (!r.command.save_cache.empty()) json["cache"] = r.command.save_cache;
  if (!r.result.fallback.empty()) json["fallback"] = r.result.fallback;
  if (const auto& missed = r.result.out_of_reach; !missed.empty())
    json["out_of_reach"] = fmt::format("{}", fmt::join(missed, "\n"));
  if (r.result.chosen) json["chosen"] = {{"integrator", r.result.chosen->label()}, {"why", r.result.why}};
  if (r.result.chosen_accel) json["chosen_accel"] = {{"accel", r.result.chosen_accel->label()}, {"why", r.result.accel_why}};
  if (r.result.stopped) json["interrupted"] = true;
  if (r.repeats) json["repeats"] = {{"image", r.command.from}, {"to_the_bit", *r.repeats}};
  if (!r.reference.empty()) json["reference"] = r.reference;
  for (const auto& [name, value] : r.metrics) json[name] = value;
  return dump(json, 2);
}

std::string to_lines(const Rendering& r) {
  const CheckpointRecord& end = r.result.checkpoints.back();
  std::string text = fmt::format("image       {}\n", r.output);
  for (const std::string& aov : r.command.aovs) text += fmt::format("aov         {}\n", aov_path(r.output, aov));
  if (!r.command.save_cache.empty()) text += fmt::format("cache       {}\n", r.command.save_cache);
  if (r.repeats) text += fmt::format("repeats     {}{}\n", r.command.from, *r.repeats ? ", to the bit" : ": no, other bits");
  if (r.result.chosen) text += fmt::format("method      {}\n", r.result.chosen->label());
  if (r.result.chosen_accel) text += fmt::format("structure   {}\n", r.result.chosen_accel->label());
  text += fmt::format("hash        {:016x}\nspp         {}\ntime        {}", r.result.image_hash, end.iterations,
                      format_seconds(end.time_s));
  std::string separator = " (";
  for (const auto& [phase, seconds] : end.phases_s)
    text += std::exchange(separator, ", ") + phase + " " + format_seconds(seconds);
  text += fmt::format(")\nmemory      {} at most\n", format_bytes(static_cast<double>(end.peak_memory_bytes)));
  for (const auto& [name, value] : r.metrics) text += fmt::format("{:<15} {:.4g}\n", name, value);
  if (!r.reference.empty()) text += fmt::format("against     {}\n", r.reference);
  return text;
}

}  // namespace etendue
