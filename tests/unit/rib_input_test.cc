// SPDX-License-Identifier: Apache-2.0
// Inputs: files, pipes, gzip in all its states, and limits.
#include <gtest/gtest.h>

#include <unistd.h>
#include <zlib.h>

#include <cstdlib>
#include <fstream>
#include <thread>

#include "rib_recorder.h"

namespace patina::test {
namespace {

std::string gzip(const std::string& text) {
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY);
  std::string result(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  deflate(&stream, Z_FINISH);
  result.resize(stream.total_out);
  deflateEnd(&stream);
  return result;
}

class RibInput : public testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/patina_rib_XXXXXX";
    descriptor = mkstemp(name);
    path = name;
  }
  void TearDown() override {
    close(descriptor);
    unlink(path.c_str());
  }
  bool parseAsFile(const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
    return parser.parseFile(path);
  }
  bool parseAsPipe(const std::string& bytes) {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    std::thread writer([&] {
      for (size_t i = 0; i < bytes.size();) {
        const ssize_t n = write(ends[1], bytes.data() + i, std::min<size_t>(bytes.size() - i, 1000));
        if (n <= 0) break;
        i += static_cast<size_t>(n);
      }
      close(ends[1]);
    });
    const bool complete = parser.parseDescriptor(ends[0], "pipe");
    writer.join();
    close(ends[0]);
    return complete;
  }
  Lines take() { return std::exchange(recorder.lines, {}); }

  int descriptor = -1;
  std::string path;
  Recorder recorder;
  Lines printed;
  ErrorHandler errors{[this](Severity, std::string_view m) { printed.emplace_back(m); }};
  RibParser parser{recorder, errors};
};

const std::string kRib = "Sides 1\nSphere 1 -1 1 360\nSides 2";
const Lines kLines = {"Sides 1", "Sphere 1 -1 1 360 {}", "Sides 2"};

TEST_F(RibInput, FilesAndPipesAndMemory) {
  EXPECT_TRUE(parseAsFile(kRib));
  EXPECT_EQ(take(), kLines);
  EXPECT_EQ(toString(recorder.places[1]), path + ":2:1");
  EXPECT_TRUE(parseAsPipe(kRib));
  EXPECT_EQ(take(), kLines);
  EXPECT_TRUE(parseAsFile(""));
  EXPECT_TRUE(parseAsPipe(""));
  EXPECT_EQ(take(), Lines{});
  // Exactly one page: there is no byte behind the mapping.
  std::string page = kRib;
  page.insert(7, std::string(4096 - kRib.size(), ' '));
  EXPECT_TRUE(parseAsFile(page));
  EXPECT_EQ(take(), kLines);
}

TEST_F(RibInput, GzipIsToldByItsFirstBytes) {
  EXPECT_TRUE(parseAsFile(gzip(kRib)));
  EXPECT_EQ(take(), kLines);
  EXPECT_TRUE(parseAsPipe(gzip(kRib)));
  EXPECT_EQ(take(), kLines);
  EXPECT_TRUE(parser.parseMemory(gzip(kRib), "m"));
  EXPECT_EQ(take(), kLines);
}

TEST_F(RibInput, GzipOfManyMembers) {
  // A request may span two of them; empty members and zero padding behind the last are harmless.
  EXPECT_TRUE(parseAsFile(gzip("Sides 1\nSphe") + gzip("") + gzip("re 1 -1 1 360\n") + gzip("Sides 2") +
                          std::string(512, '\0')));
  EXPECT_EQ(take(), kLines);
  EXPECT_EQ(printed, Lines{});
}

TEST_F(RibInput, LargeGzip) {
  std::string rib;
  for (int i = 0; i < 200000; ++i) rib += "Sides 1\n";
  EXPECT_TRUE(parseAsFile(gzip(rib)));
  EXPECT_EQ(recorder.lines.size(), 200000u);
}

TEST_F(RibInput, DamagedGzipGivesWhatCameBefore) {
  std::string rib = kRib + "\n";
  for (int i = 0; i < 5000; ++i) rib += "# " + std::to_string(i * 7919) + "\n";
  const std::string whole = gzip(rib);
  EXPECT_FALSE(parseAsFile(whole.substr(0, whole.size() / 2)));
  EXPECT_EQ(take(), kLines);
  EXPECT_EQ(
      printed,
      Lines{path + ": error: badfile: damaged gzip data (it ends too early); what came before is used"});
  printed.clear();
  std::string wrongSum = whole;
  wrongSum[wrongSum.size() - 6] = static_cast<char>(wrongSum[wrongSum.size() - 6] ^ 1);
  EXPECT_FALSE(parseAsFile(wrongSum));
  EXPECT_EQ(take(), kLines);
  EXPECT_EQ(printed.size(), 1u);
  EXPECT_FALSE(parseAsFile("\x1f\x8b"));
  EXPECT_FALSE(parseAsFile("\x1f\x8bgarbage that is no gzip"));
  EXPECT_EQ(take(), Lines{});
}

TEST_F(RibInput, BombsStop) {
  const std::string bomb = gzip("Sides 1\n" + std::string(16 << 20, ' '));
  ASSERT_LT(bomb.size(), 100000u);
  RibParser careful(recorder, errors, {.inflateFreely = 1 << 20, .inflateRatio = 100});
  EXPECT_FALSE(careful.parseMemory(bomb, "bomb"));
  EXPECT_EQ(take(), Lines{"Sides 1"});
  ASSERT_EQ(printed.size(), 1u);
  EXPECT_TRUE(printed[0].starts_with("bomb: error: limitcheck: ")) << printed[0];
  EXPECT_TRUE(parser.parseMemory(bomb, "within the default limits"));
}

TEST_F(RibInput, LongPipesStop) {
  RibParser careful(recorder, errors, {.inputBytes = 8});
  std::string rib = kRib + std::string(1 << 20, ' ');
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  std::thread writer([&] {
    ASSERT_EQ(write(ends[1], rib.data(), 4096), 4096);
    close(ends[1]);
  });
  EXPECT_FALSE(careful.parseDescriptor(ends[0], "pipe"));
  writer.join();
  close(ends[0]);
  EXPECT_EQ(take(), Lines{"Sides 1"});
  EXPECT_EQ(printed, Lines{"pipe: error: limitcheck: more than 8 bytes of input; the rest is ignored"});
}

}  // namespace
}  // namespace patina::test
