// SPDX-License-Identifier: Apache-2.0
// Runs a fuzz target on files and on the files of folders, whole and cut in the middle.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  std::vector<fs::path> files;
  for (int k = 1; k < argc; ++k) {
    if (!fs::is_directory(argv[k]))
      files.emplace_back(argv[k]);
    else
      for (const fs::directory_entry& entry : fs::directory_iterator(argv[k]))
        if (entry.is_regular_file()) files.push_back(entry.path());
  }
  for (const fs::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
    const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
    const size_t step = std::max<size_t>(1, bytes.size() / 500);
    for (size_t size = 0; size < bytes.size(); size += step) {
      const std::vector<uint8_t> part(data, data + size);  // of its own, so that reading beyond it is noticed
      LLVMFuzzerTestOneInput(part.data(), part.size());
    }
    LLVMFuzzerTestOneInput(data, bytes.size());
  }
  std::printf("%zu inputs\n", files.size());
  return files.empty() ? 1 : 0;
}
