// How much a method gets done in a second: camera samples, rays, photons and records, with each instruction set.
#pragma once

#include "experiments/log/log.h"
#include "experiments/report/kind_report.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace etendue {

// These are medians over the repetitions with one instruction set.
struct Throughput {
  std::string isa;                       // as --isa takes it
  std::uint64_t iterations = 0;          // of each repetition
  Measured samples_per_s;                // camera samples, by the time of the whole render but for reading the scene
  Measured rays_per_s;                   // of all kinds, likewise
  Measured photons_per_s;                // emitted, by the time of emission alone
  Measured records_per_s;                // of caches, by the time of the initial pass alone
  std::map<std::string, double> shares;  // of each phase in the time
};

// A cell's scene and method, and as its structure the commit of the program: a log keeps those of every commit that ran.
struct ThroughputRecord final : KindRecord {
  static constexpr const char* type = "throughput";

  Parameters parameters = {};  // of the method
  std::string image_hash;      // the same with every instruction set
  std::vector<Throughput> sets;

  const std::string& commit() const { return cell.accel; }
  std::string line() const override;
};

// Tables and charts: the newest commit's figures, and what each commit before it had.
KindReport throughput_report(const RunLog& log);
std::string throughput_summary(const RunLog& log);

}  // namespace etendue
