// Errors that others measured and that cannot be measured here: other programs, other machines. They enter as data, with their
// source, and the report draws them as such beside what was measured.
//
//   [[elsewhere]]
//   scene   = "cornell-boxes"                 # by name, or by its file's name without folder and ending; others are left out
//   program = "Mitsuba 3.6.4, LLVM, 16 lanes"
//   method  = "path"                          # in that program's words
//   time    = "6.5s"                          # until the image was there
//   error   = 9.2e-4
//   metric  = "relmse"                        # default
//   machine = "2 cores of an EPYC (Zen 4), AVX-512"
//   date    = "2026-11-21"
//   source  = "where the figure stands"
#pragma once

#include "experiments/config/config_tree.h"

#include <string>
#include <vector>

namespace etendue {

struct ElsewhereFigure {
  std::string scene, program, method, metric = "relmse", machine, date, source;
  double time_s = 0, error = 0;

  bool of_scene(const std::string& name) const;
  bool operator==(const ElsewhereFigure&) const = default;
};

// Throws Error. The scenes need not be the experiment's: figures are of whatever it is run over.
std::vector<ElsewhereFigure> read_elsewhere(const ConfigNode& node);

}  // namespace etendue
