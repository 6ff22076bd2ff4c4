// Claims, and the measurements that test them.
//
// A claim states figures; a measurement gives figures of one scene. A claim expects some of them to lie in an interval;
// experiments/statistics/verdict.h compares the two. Variants of the product's code and scenes that only claims need are in
// this folder.
#pragma once

#include "experiments/kinds/claims/claim_record.h"
#include "framework/core/error.h"
#include "framework/io/scene_files.h"

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace etendue {

struct Quantity {
  std::string name;  // as an experiment's `expect` names it
  FigureKind kind = FigureKind::factor;
  std::string text;  // what it is, for a table
};

struct MeasureTask {
  std::string scene;     // as load_claim_scene takes it
  int resolution = 256;  // about resolution^2 rays of a kind
  int repetitions = 9;   // interleaved, of which medians and quartiles are taken
  int threads = 1;       // of a measurement that is parallel
  std::uint64_t seed = 1;
  std::function<void(double share)> progress = [](double) {};
  SceneReading reading = {};
};

struct MeasureResult {
  std::vector<std::pair<std::string, Measured>> figures;  // by quantity
  std::vector<std::string> remarks;                       // what a reader of the figures must know
  std::uint64_t disagreements = 0;                        // answers of a variant that are not the product's

  void add(const char* quantity, const Measured& value) { figures.emplace_back(quantity, value); }
  void add(const char* quantity, double value) { add(quantity, {value, value, value}); }  // counted, or computed
};

struct Measurement {
  std::string name, summary;
  std::vector<Quantity> quantities;
  MeasureResult (*run)(const MeasureTask&);
  bool parallel = false;  // runs its loops on MeasureTask::threads; others get one thread

  const Quantity* quantity(std::string_view quantity_name) const;
};

std::span<const Measurement> measurements();
const Measurement& find_measurement(const std::string& name, const Location& where);  // throws Error

// The rows of the table, by file.
std::vector<Measurement> builder_measurements();    // which tree
std::vector<Measurement> traversal_measurements();  // how it is walked
std::vector<Measurement> change_measurements();     // what becomes of it
std::vector<Measurement> space_measurements();      // trees of boxes against cells of space
std::vector<Measurement> object_measurements();     // cylinders, rotated objects, few objects
std::vector<Measurement> image_measurements();      // whole images: seconds, tasks
std::vector<Measurement> sampling_measurements();   // directions, caches
std::vector<Measurement> content_measurements();    // what a scene is spared that lacks a thing

}  // namespace etendue
