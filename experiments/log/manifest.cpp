#include "experiments/log/manifest.h"

#include <etendue_commit.h>
#include <fmt/format.h>
#include <xxhash.h>
#include <fstream>

namespace etendue {

namespace {

constexpr const char* compiler =
#if defined(__clang__)
    "Clang " __clang_version__;
#elif defined(__GNUC__)
    "GCC " __VERSION__;
#else
    "unknown";
#endif

std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    const auto colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

ManifestRecord make_manifest(const std::string& title, const std::string& experiment_hash, int threads) {
  ManifestRecord record{"",          ETENDUE_VERSION, ETENDUE_COMMIT,  compiler, ETENDUE_FLAGS,
                        cpu_model(), title,           experiment_hash, threads};
  const std::string text = to_json_line(record);
  record.id = fmt::format("{:016x}", XXH3_64bits(text.data(), text.size()));
  return record;
}

std::string version_text() { return fmt::format("etendue {} ({})", ETENDUE_VERSION, ETENDUE_COMMIT); }

}  // namespace etendue
