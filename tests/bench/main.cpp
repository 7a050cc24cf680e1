// What every bench program begins with.
#include <benchmark/benchmark.h>

#include "common/base/memory.h"

int main(int argc, char** argv) {
  meshloop::keep_memory_between_frames();  // as the programs do
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
