#include "experiments/log/log.h"

#include "framework/core/isa.h"
#include "framework/core/parallel.h"

#include <etendue_build.h>
#include <fmt/chrono.h>
#include <unistd.h>
#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <map>

namespace etendue {

extern const char* const built_commit;  // write_commit.cmake

namespace {

constexpr const char* compiler =
#if defined(__clang__)
    "Clang " __clang_version__;
#elif defined(__GNUC__)
    "GCC " __VERSION__;
#else
    "unknown";
#endif

// The facts that the kernel states of the first processor, by its keys.
std::map<std::string, std::string> cpu_facts() {
  std::map<std::string, std::string> facts;
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line) && !line.empty();)
    if (const auto colon = line.find(':'); colon != std::string::npos)
      facts[line.substr(0, line.find_last_not_of(" \t", colon - 1) + 1)] = line.substr(std::min(line.size(), colon + 2));
  return facts;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  return fmt::format("{:%Y-%m-%d}", fmt::gmtime(now));
}

}  // namespace

ManifestRecord make_manifest(const std::string& title, const std::string& experiment_hash, int threads) {
  std::map<std::string, std::string> cpu = cpu_facts();
  const auto text = [&](const char* key) { return cpu[key].empty() ? "unknown" : cpu[key]; };
  const auto number = [&](const char* key) { return std::atoi(cpu[key].c_str()); };
  ManifestRecord record{"",    ETENDUE_VERSION, built_commit, compiler, ETENDUE_FLAGS, text("model name"),
                        title, experiment_hash, threads};
  record.cpu_vendor = text("vendor_id");
  record.cpu_family = number("cpu family");
  record.cpu_model = number("model");
  record.cpu_stepping = number("stepping");
  record.isa = isa_name(chosen_isa());
  record.cores = hardware_threads();
  record.memory_bytes = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  record.id = hash_text(to_json_line(record));
  record.date = today();  // not in the id: a run that goes on the next day is the same one
  return record;
}

std::string version_text() { return fmt::format("etendue {} ({})", ETENDUE_VERSION, built_commit); }

}  // namespace etendue
