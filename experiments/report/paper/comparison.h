// A figure of a paper from what a run kept: the images of methods and the reference side by side, windows of them enlarged
// below, and how these differ from the reference.
#pragma once

#include "experiments/report/paper/pictures.h"

#include <string>
#include <vector>

namespace etendue {

struct Configuration;
struct Replicate;
struct SceneData;

struct KeptImage {
  const Configuration* configuration;
  const Replicate* replicate;
};
// Each integrator gives the image of its lowest seed, with the first structure that kept one.
std::vector<KeptImage> kept_images(const SceneData& scene);

struct ComparisonChoice {
  std::string scene;                 // a scene's name; "": the first of which images were kept
  std::vector<std::string> methods;  // names or labels, in the figure's order; none: all whose image was kept
  std::vector<Window> windows;       // none: the two in which the methods' errors are largest
};

struct Comparison {
  std::vector<std::string> files;  // that were written
  std::vector<std::string> notes;  // what is not to be believed of the logs
};

// Reads the logs in `directories` and writes `file` (.png), beside it a LaTeX document of the same figure (.tex) and the parts
// that this includes (folder NAME-parts). Throws Error where names are unknown, windows leave the image, or images are missing
// or of different sizes.
Comparison write_comparison(const std::vector<std::string>& directories, const std::string& file,
                            const ComparisonChoice& choice);

}  // namespace etendue
