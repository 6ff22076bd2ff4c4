// The part of a cache file after its key (cache_file.h), for all kinds of records (record_levels.h): the histories from which
// records are made again, and the state of the refinement.
//
//   u64  view: hash of scene, camera, resolution and seed for which it was filled last
//   u64  key salt (RecordLevels::resume)
//   u32  iterations behind it
//   u32  stage of the refinement
//   f32  accuracy reached
//   then, of each kind of record:
//   u64  number of levels; of each: u64 number of records; of each:
//          f32 position[3], normal[3], geometric normal[3], pixel width; i32 depth; u64 key; i32 passes; their mean
//
// For each kind of record, `transfer` defines the fields of the mean that are read and written, and a check whether their
// values are possible.
#pragma once

#include "integrators/caches/records/cache_file.h"
#include "integrators/caches/records/cache_progress.h"
#include "integrators/caches/records/hemisphere.h"
#include "integrators/caches/records/record_levels.h"

#include <cmath>
#include <vector>

namespace etendue {

// How far a cache of records has come, fresh or from a file.
class CacheStanding {
 public:
  void write(ByteWriter& out, float accuracy) const;
  void read(ByteReader& in);

  bool loaded() const { return loaded_; }
  float accuracy() const { return accuracy_; }  // when it was saved
  std::uint64_t key_salt() const { return key_salt_; }

  // Continues after the rounds done so far; without refinement, or with a given number of records, after the overture.
  void begin(const RenderContext& context, bool has_overture);
  std::uint32_t first_round() const { return first_round_; }
  std::uint32_t rounds() const { return rounds_; }
  void reached(std::uint32_t rounds) { rounds_ = rounds; }
  std::uint32_t stage() const { return stage_; }
  std::uint32_t spacing() const { return spacing_; }  // the stage whose accuracy records have
  void enter(std::uint32_t stage, std::uint32_t spacing) { stage_ = stage, spacing_ = spacing; }
  bool cut_short() const { return cut_short_; }  // loaded records have fewer rays than the stage's
  // The accuracy that loaded records must have before the next round. Those that have one of a refinement's keep that.
  float accuracy_wanted(const CacheProgress& progress);
  // Is there anything that loaded records may not cover? What is covered is not visited again, so that a cache without
  // refinement is the same whether loaded or new.
  bool needs_filling(float accuracy) const { return !same_view_ || accuracy != accuracy_; }

 private:
  std::uint64_t view_ = 0, key_salt_ = 0;
  std::uint32_t rounds_ = 0, first_round_ = 0, stage_ = 0, spacing_ = 0;
  float accuracy_ = 0;
  bool loaded_ = false, same_view_ = false, cut_short_ = false;
};

bool is_unit(const vec3& v);
bool is_valid(const CachePoint& point);

// Transfers the mean of an irradiance record's passes: f32 irradiance[3], inverse distance, least distance, variance, shared
// variance; u32 source; f32 rotation[9], translation[9]; f64 hessian[3], geometric[3].
template <class Io, class Estimate>
requires std::is_same_v<std::remove_const_t<Estimate>, IrradianceEstimate>
void transfer(const Io& io, Estimate& mean) {
  // A field that is added must be written here, and the format's number raised.
  static_assert(sizeof(IrradianceEstimate) == 26 * sizeof(float) + 6 * sizeof(double));
  io(mean.irradiance), io(mean.inverse_distance), io(mean.nearest), io(mean.variance);
  io(mean.shared_variance), io(mean.source), io(mean.rotation), io(mean.translation);
  for (auto* matrix : {&mean.hessian, &mean.geometric}) io(matrix->xx), io(matrix->xy), io(matrix->yy);
}
bool is_valid(const IrradianceEstimate& mean);

// `io` is a ByteWriter's add or a ByteReader's take, so that reading and writing have one order.
template <class Io, class History>
void transfer_history(const Io& io, History& h) {
  io(h.point.position), io(h.point.normal), io(h.point.geometric), io(h.point.origin), io(h.point.pixel_width),
      io(h.point.depth);
  io(h.key), io(h.passes);
  transfer(io, h.mean);
}

template <class History>
void write_levels(ByteWriter& out, const std::vector<std::span<const History>>& levels) {
  out.add(static_cast<std::uint64_t>(levels.size()));
  for (const auto& histories : levels) {
    out.add(static_cast<std::uint64_t>(histories.size()));
    for (const History& history : histories) transfer_history([&](const auto& value) { out.add(value); }, history);
  }
}

// Throws Error unless every value is one that a record can hold. `one_level`: all depths share the first level; `empty`: a mean
// of as many values as the file's have.
template <class Estimate>
std::vector<std::vector<RecordHistoryOf<Estimate>>> read_levels(ByteReader& in, bool one_level, const Estimate& empty) {
  RecordHistoryOf<Estimate> blank{{}, 0, empty, 0};
  ByteWriter one;
  transfer_history([&](const auto& value) { one.add(value); }, blank);
  const std::size_t count = in.take_count(sizeof(std::uint64_t));
  if (count > static_cast<std::size_t>(one_level ? 1 : shared_above + 1)) in.refuse("more levels than depths");
  std::vector<std::vector<RecordHistoryOf<Estimate>>> levels;
  for (std::size_t i = 0; i < count; ++i) {
    auto& histories = levels.emplace_back(in.take_count(one.bytes.size()), blank);
    for (auto& history : histories) {
      transfer_history([&](auto& value) { in.take(value); }, history);
      if (!is_valid(history.point) || !is_valid(history.mean) || history.passes < 1 ||
          (!one_level && static_cast<std::size_t>(history.point.depth) != i))
        in.refuse("a record holds what none can");
    }
  }
  return levels;
}

}  // namespace etendue
