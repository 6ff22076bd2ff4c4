#include "experiments/kinds/search/measure_search.h"

#include "accel/registry.h"
#include "experiments/kinds/search/search_sets.h"
#include "experiments/kinds/timing.h"
#include "experiments/statistics/statistics.h"
#include "framework/core/parallel.h"
#include "framework/core/rng.h"

#include <bit>
#include <optional>

namespace etendue {

namespace {

constexpr double batch_s = 0.02;  // a batch of a slow structure is cut to about this

// Equal sets have the same sum, in whatever order.
std::uint64_t checksum(const Neighbours& found) {
  std::uint64_t sum = mix_bits(found.size());
  for (const Neighbour& n : found) sum += hash_keys(n.id, std::bit_cast<std::uint32_t>(n.distance_squared));
  return sum;
}

// Seconds of each of `count` pieces of work.
Measured of_each(std::vector<double> seconds, double count) {
  for (double& s : seconds) s /= count;
  return summarise(seconds);
}

template <class Structure>
using Structures = std::vector<std::unique_ptr<Structure>>;

// Asks each structure the same queries: ask(structure, query, out).
template <class Structure, class Ask>
class Queries {
 public:
  Queries(const Structures<Structure>& structures, std::size_t count, const Ask& ask)
      : structures_(structures), count_(count), ask_(ask) {
    for (std::size_t s = 0; s < structures.size(); ++s) {
      const std::size_t few = std::min<std::size_t>(count, 16);
      run(s, few);  // warm
      const double one = seconds_of([&] { run(s, few); }, Clock::thread) / static_cast<double>(few) + 1e-9;
      batches_.push_back(std::clamp(static_cast<std::size_t>(batch_s / one), few, count));
    }
  }

  // Adds a batch for each structure.
  void add_to(std::vector<TimedWork>& works) {
    for (std::size_t s = 0; s < structures_.size(); ++s)
      works.push_back(timed([this, s] { run(s, batches_[s]); }, Clock::thread));
  }

  // Compares all answers, and appends a figure for each structure; `times` are those of its batches.
  void finish(const char* measure, double parameter, std::span<const std::vector<double>> times, const SearchChoice& choice,
              SearchRecord& record) {
    std::vector<std::optional<std::uint64_t>> expected(count_);
    for (std::size_t s = 0; s < structures_.size(); ++s) {
      std::size_t found = 0;
      for (std::size_t i = 0; i < batches_[s]; ++i) {
        const std::size_t at = query(i, batches_[s]);
        ask_(*structures_[s], at, out_);
        found += out_.size();
        const std::uint64_t sum = checksum(out_);
        if (!expected[at]) {
          expected[at] = sum;
          continue;
        }
        ++record.checked;
        record.disagreements += *expected[at] != sum;
      }
      const auto asked = static_cast<double>(batches_[s]);
      record.figures.push_back(
          {choice.structures[s], measure, parameter, of_each(times[s], asked), static_cast<double>(found) / asked});
    }
  }

 private:
  // A batch is spread over all queries, since those of one place follow each other.
  std::size_t query(std::size_t i, std::size_t batch) const { return i * count_ / batch; }
  void run(std::size_t s, std::size_t batch) {
    for (std::size_t i = 0; i < batch; ++i) ask_(*structures_[s], query(i, batch), out_);
  }

  const Structures<Structure>& structures_;
  std::size_t count_;  // of queries
  const Ask& ask_;
  std::vector<std::size_t> batches_;  // their sizes
  Neighbours out_;
};

// Each repetition makes all structures anew: make(name) is timed; the last ones stay.
template <class Structure, class Make>
Structures<Structure> time_making(const SearchTask& task, const char* measure, const Make& make, SearchRecord& record) {
  const auto& names = task.choice.structures;
  Structures<Structure> structures(names.size());
  std::vector<TimedWork> works;
  for (std::size_t s = 0; s < names.size(); ++s)
    works.push_back([&, s] {
      structures[s] = nullptr;
      return seconds_of([&] { structures[s] = make(names[s]); }, Clock::thread);
    });
  const Times times = take_turns(works, task.choice.repetitions);
  const auto count = static_cast<double>(task.count);
  for (std::size_t s = 0; s < names.size(); ++s) {
    record.figures.push_back({names[s], measure, 0, of_each(times[s], count), 0});
    const double bytes = static_cast<double>(structures[s]->bytes()) / count;
    record.figures.push_back({names[s], "memory", 0, {bytes, bytes, bytes}, 0});
  }
  return structures;
}

// Distances to the k-th neighbour: for photons of a scene the same for all queries, their median, as a fixed radius is chosen;
// on a set whose density varies on purpose each query's own, so that each finds as many.
std::vector<float> radii_for(const PointQuery& points, const PointSet& set, std::size_t k, bool own) {
  std::vector<double> distances;
  Neighbours out;
  for (const vec3& p : set.queries) {
    points.nearest(p, k, infinity, out);
    distances.push_back(std::sqrt(out.back().distance_squared));
  }
  const auto middle = static_cast<float>(median(distances));
  return mapped(distances, [&](double d) { return own ? static_cast<float>(d) : middle; });
}

void measure_points(const SearchTask& task, SearchRecord& record) {
  const auto queries = static_cast<std::uint64_t>(task.choice.queries);
  const PointSet set = task.scene ? photons_of_scene(*task.scene, task.count, queries, task.seed)
                                  : clustered_points(task.set.variation, task.count, queries, task.seed);
  const auto make = [&](const std::string& name) {
    auto points = find_point_structure(name, {}).make();
    points->build(set.points);
    return points;
  };
  const auto structures = time_making<PointQuery>(task, "build", make, record);
  const auto guide = make("hash-grid");
  for (std::size_t i = 0; i < task.choice.neighbours.size(); ++i) {
    const std::size_t k = task.choice.neighbours[i];
    if (task.progress) task.progress((1 + static_cast<double>(i)) / (1 + static_cast<double>(task.choice.neighbours.size())));
    if (4 * k > task.count && k > 1) continue;
    const std::vector<float> radii = radii_for(*guide, set, k, !task.scene);
    const auto within = [&](const PointQuery& s, std::size_t q, Neighbours& out) { s.within(set.queries[q], radii[q], out); };
    const auto nearest = [&](const PointQuery& s, std::size_t q, Neighbours& out) {
      s.nearest(set.queries[q], k, infinity, out);
    };
    Queries by_radius(structures, set.queries.size(), within);
    Queries by_number(structures, set.queries.size(), nearest);
    std::vector<TimedWork> works;
    by_radius.add_to(works);
    by_number.add_to(works);
    const Times times = take_turns(works, task.choice.repetitions);
    by_radius.finish("within", static_cast<double>(k), std::span(times).first(structures.size()), task.choice, record);
    by_number.finish("nearest", static_cast<double>(k), std::span(times).last(structures.size()), task.choice, record);
  }
}

void measure_records(const SearchTask& task, SearchRecord& record) {
  const RecordSet set = records_of_scene(*task.scene, task.set.variation, task.choice.covering, task.count,
                                         static_cast<std::uint64_t>(task.choice.queries), task.seed);
  const Bounds bounds = task.scene->bounds();
  const auto make = [&](const std::string& name) {
    auto records = find_record_structure(name, {}).make(bounds);
    for (std::uint32_t id = 0; id < set.centres.size(); ++id) records->insert(set.centres[id], set.radii[id], id);
    return records;
  };
  const auto structures = time_making<RecordQuery>(task, "insert", make, record);
  if (task.progress) task.progress(0.5);
  const auto covering = [&](const RecordQuery& s, std::size_t q, Neighbours& out) { s.covering(set.queries[q], out); };
  Queries queries(structures, set.queries.size(), covering);
  std::vector<TimedWork> works;
  queries.add_to(works);
  queries.finish("covering", 0, take_turns(works, task.choice.repetitions), task.choice, record);
}

}  // namespace

SearchRecord measure_search(const SearchTask& task) {
  SearchRecord record;
  record.kind = task.choice.kind();
  record.set = task.set.name;
  record.varies = task.set.varies;
  record.variation = task.set.variation;
  record.count = task.count;
  with_threads(1, [&] { task.choice.records ? measure_records(task, record) : measure_points(task, record); });
  return record;
}

}  // namespace etendue
