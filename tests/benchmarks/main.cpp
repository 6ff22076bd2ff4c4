// Runs the micro-benchmarks. Debian's library warns that *it* was built for debugging; what counts is how we were built, which
// stands in the context.
#include "framework/core/parallel.h"

#include <benchmark/benchmark.h>

int main(int argc, char** argv) {
#ifdef NDEBUG
  benchmark::AddCustomContext("etendue_build", "release");
#else
  benchmark::AddCustomContext("etendue_build", "debug: figures mean nothing");
#endif
  benchmark::AddCustomContext("etendue_compiler", __VERSION__);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  etendue::with_threads(1, [] { benchmark::RunSpecifiedBenchmarks(); });
  benchmark::Shutdown();
}
