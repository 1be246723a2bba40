// SPDX-License-Identifier: Apache-2.0
// How fast RIB is read: bytes of the file per second, beside a memory copy and a count of lines of the same
// file.
//
//   bench_rib                       100 MB files, made anew in the temporary folder and removed at the end
//   PATINA_BENCH_MB=10 bench_rib    smaller ones
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "rib/parser.h"
#include "rib/writer.h"

namespace patina {
namespace {

size_t wantedBytes() {
  const char* const megabytes = std::getenv("PATINA_BENCH_MB");
  return static_cast<size_t>(megabytes ? std::max(1, std::atoi(megabytes)) : 100) << 20;
}

/// A mesh as exporters write it: coordinates of six decimals, 20 values a line.
std::string meshText() {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> coordinate(-10, 10);
  const size_t vertices = wantedBytes() / 60;  // 27 bytes of P, 27 of N, and faces
  std::string text = "PointsPolygons [";
  const auto number = [&](const auto& value, size_t k) {
    text += k % 20 == 19 ? '\n' : ' ';
    fmt::format_to(std::back_inserter(text), "{}", value);
  };
  for (size_t k = 0; k < vertices / 4; ++k) number(4, k);
  text += "]\n[";
  for (size_t k = 0; k < vertices / 4 * 4; ++k) number(random() % vertices, k);
  for (const char* name : {"P", "N"}) {
    text += fmt::format("]\n\"{}\" [", name);
    for (size_t k = 0; k < 3 * vertices; ++k) {
      text += k % 20 == 19 ? '\n' : ' ';
      fmt::format_to(std::back_inserter(text), "{:.6f}", coordinate(random));
    }
  }
  return text + "]\n";
}

/// Small requests, as a scene of many spheres has them.
std::string requestsText() {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> coordinate(-10, 10);
  std::string text;
  while (text.size() < wantedBytes())
    fmt::format_to(
        std::back_inserter(text),
        "AttributeBegin\nColor [{:.3f} 0.5 1]\nTranslate {:.4f} {:.4f} 5\nSurface \"plastic\" \"Kd\" [0.8] "
        "\"roughness\" 0.25\nSphere 1 -1 1 360\nAttributeEnd\n",
        std::abs(coordinate(random)) / 10, coordinate(random), coordinate(random));
  return text;
}

std::string binaryOf(const std::string& rib) {
  std::string binary;
  ErrorHandler errors;
  RibWriter writer(
      [&](std::string_view piece) {
        binary += piece;
        return true;
      },
      {.encoding = RibEncoding::Binary});
  RibParser(writer, errors).parseMemory(rib, "bench");
  writer.flush();
  return binary;
}

/// A file that is removed at the end.
class File {
 public:
  explicit File(std::string text) : text_(std::move(text)) {
    path_ =
        (std::filesystem::temp_directory_path() / fmt::format("patina-bench-{}-{}.rib", getpid(), count_++))
            .string();
    std::ofstream(path_, std::ios::binary).write(text_.data(), static_cast<std::streamsize>(text_.size()));
  }
  ~File() { std::filesystem::remove(path_); }
  const std::string& path() const { return path_; }
  const std::string& text() const { return text_; }

 private:
  static inline int count_ = 0;
  std::string path_, text_;
};

const File& mesh() {
  static const File file(meshText());
  return file;
}
const File& requests() {
  static const File file(requestsText());
  return file;
}
const File& binaryMesh() {
  static const File file(binaryOf(mesh().text()));
  return file;
}
const File& binaryRequests() {
  static const File file(binaryOf(requests().text()));
  return file;
}

void setBytes(benchmark::State& state, const File& file) {
  state.SetBytesProcessed(static_cast<int64_t>(state.iterations()) *
                          static_cast<int64_t>(file.text().size()));
}

/// Counts values, so that none of them is for nothing.
struct Counter final : RibHandler {
  size_t values = 0;
  void pointsPolygons(Ints counts, Ints vertices, const ParamList& params, const Location&) override {
    values += counts.size() + vertices.size();
    for (const Param& param : params) values += param.floats.size();
  }
};

void parse(benchmark::State& state, const File& file) {
  ErrorHandler errors;
  Counter counter;
  for (auto _ : state) {
    RibParser parser(counter, errors);
    if (!parser.parseFile(file.path())) state.SkipWithError("not read");
  }
  setBytes(state, file);
  state.counters["values/s"] =
      benchmark::Counter(static_cast<double>(counter.values), benchmark::Counter::kIsRate);
}

void ParseAsciiMesh(benchmark::State& state) { parse(state, mesh()); }
void ParseAsciiRequests(benchmark::State& state) { parse(state, requests()); }
void ParseBinaryMesh(benchmark::State& state) { parse(state, binaryMesh()); }
void ParseBinaryRequests(benchmark::State& state) { parse(state, binaryRequests()); }

void CopyMemory(benchmark::State& state) {
  std::string copy(mesh().text().size(), ' ');
  for (auto _ : state) {
    std::memcpy(copy.data(), mesh().text().data(), copy.size());
    benchmark::DoNotOptimize(copy.data());
    benchmark::ClobberMemory();
  }
  setBytes(state, mesh());
}

void CountLines(benchmark::State& state) {
  const std::string command = "wc -l " + mesh().path() + " > /dev/null";
  for (auto _ : state)
    if (std::system(command.c_str()) != 0) state.SkipWithError("wc does not run");
  setBytes(state, mesh());
}

/// Bytes of memory of this process that are no file's.
double anonymousBytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (double kilobytes; word == "RssAnon:" && status >> kilobytes) return kilobytes * 1024;
  return 0;
}

/// Memory that reading the mesh adds, beside the bytes of its values, when the handler gets them.
void PeakMemory(benchmark::State& state) {
  struct Meter final : RibHandler {
    double peak = 0, parsed = 0;
    void pointsPolygons(Ints counts, Ints vertices, const ParamList& params, const Location&) override {
      size_t values = counts.size() + vertices.size();
      for (const Param& param : params) values += param.floats.size();
      parsed = static_cast<double>(values) * 4;
      peak = anonymousBytes();
    }
  } meter;
  const std::string& path = mesh().path();
  double before = 0;
  for (auto _ : state) {
    before = anonymousBytes();
    ErrorHandler errors;
    RibParser(meter, errors).parseFile(path);
  }
  state.counters["added MB"] = (meter.peak - before) / 1e6;
  state.counters["values MB"] = meter.parsed / 1e6;
  state.counters["added/values"] = (meter.peak - before) / meter.parsed;
}

BENCHMARK(CopyMemory)->Unit(benchmark::kMillisecond);
BENCHMARK(CountLines)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(ParseAsciiMesh)->Unit(benchmark::kMillisecond);
BENCHMARK(ParseAsciiRequests)->Unit(benchmark::kMillisecond);
BENCHMARK(ParseBinaryMesh)->Unit(benchmark::kMillisecond);
BENCHMARK(ParseBinaryRequests)->Unit(benchmark::kMillisecond);
BENCHMARK(PeakMemory)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace patina

BENCHMARK_MAIN();
