// One rendering of `etendue render`: what was asked for and what came of it, which the reading of its options, its loop and the
// writing of its files share.
#pragma once

#include "experiments/command/commands.h"
#include "experiments/config/budget.h"
#include "experiments/report/aov.h"
#include "experiments/run/recipe.h"
#include "experiments/run/run_cell.h"
#include "framework/image/film.h"
#include "framework/scene/scene.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace etendue {

// The recipe is that of its image, as far as it is known before.
struct Rendering : Recipe {
  const RenderCommand& command;
  CellResult result = {};
  int threads = 1;
  std::string output = {};
  std::string cache_to_load = {};     // bytes of the one to begin with
  std::optional<Recipe> recipe = {};  // of the image to repeat,
  Image original = {};                // and itself
  std::optional<bool> repeats = {};   // whether it did, to the bit
  std::string reference = {};         // what the metrics are measured against; "": none
  std::map<std::string, double> metrics = {};
  std::vector<std::string> warnings = {};  // of the scene's reader
  SceneReading reading = {};
  std::string preview_failure = {};

  ivec2 size() const { return window.end == ivec2(0) ? resolution : window.end - window.begin; }  // of what is shown
  // The part of an image as large as the whole that is shown.
  Image shown(const Image& image) const { return window.end == ivec2(0) ? image : part_of(image, window.begin, window.end); }
};

// Everything typed, checked before a scene is loaded. Throws Error naming the option.
Budget read_options(const RenderCommand& command, Rendering& r);

// "b.exr" and "records" make "b.records.exr". What is no colour has no place in a PNG.
std::string aov_path(const std::string& output, const std::string& aov);

// The image first, since it must be there in time; all else is off the clock. A file that fails does not stop the others.
void write_outputs(const Rendering& r, Integrator& integrator, const RenderContext& context, const CellResult& result);

// Says what came of it, for programs and for people.
std::string to_json(const Rendering& r);
std::string to_lines(const Rendering& r);

// Gives the scene another camera: one of the file's by its name, which brings its resolution, or "EYE TARGET [UP] [FOV]" with
// points as x,y,z in the file's coordinates and degrees across the shorter side of the image. A view that is typed is a
// pinhole's, and mirrored where the file's is; a closed form, which holds for the scene's own view, is taken away with a
// warning. Throws Error naming the option.
void set_camera(Scene& scene, const std::string& text);

// The pixels that are shown; empty: all. `crop` is what was typed: x0, x1, y0, y1 in shares of the image, or in pixels where
// one of them is above 1, rounded up as in pbrt; where nothing was, the scene file's own part counts. `needs_all` names an
// option that takes the whole image: the file's part then gives way, and a typed one is an Error, as is one that is no part.
Tile choose_window(const std::vector<double>& crop, const char* needs_all, const Scene& scene, ivec2 resolution);

}  // namespace etendue
