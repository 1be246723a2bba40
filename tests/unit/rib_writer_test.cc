// SPDX-License-Identifier: Apache-2.0
// The writer: what it writes reads as the same requests.
#include "rib/writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "every_request.h"
#include "rib/requests.h"
#include "rib_recorder.h"

namespace patina::test {
namespace {

std::string written(std::string_view rib, const RibWriterSettings& settings = {}) {
  std::string out;
  ErrorHandler errors([](Severity severity, std::string_view message) {
    if (severity >= Severity::Error) ADD_FAILURE() << message;
  });
  {
    RibWriter writer(
        [&](std::string_view text) {
          out += text;
          return true;
        },
        settings);
    RibParser(writer, errors).parseMemory(rib, "in.rib");
  }
  return out;
}

Lines recorded(std::string_view rib) {
  Parsed parsed(rib);
  EXPECT_TRUE(parsed.complete);
  EXPECT_EQ(parsed.errors.count(Severity::Error), 0u) << (parsed.messages.empty() ? "" : parsed.messages[0]);
  return parsed.recorder.lines;
}

TEST(RibWriter, EveryRequestComesBackFromBothEncodings) {
  const Lines before = recorded(kEveryRequest);
  for (const RibRequest& request : ribRequests())
    EXPECT_TRUE(std::ranges::any_of(before,
                                    [&](const std::string& line) {
                                      return line == request.name ||
                                             line.starts_with(std::string(request.name) + " ");
                                    }))
        << "the test has no " << request.name;
  const std::string ascii = written(kEveryRequest);
  const std::string binary = written(kEveryRequest, {.encoding = RibEncoding::Binary});
  EXPECT_EQ(recorded(ascii), before);
  EXPECT_EQ(recorded(binary), before);
  // Once through binary, the text is the same again, byte for byte.
  EXPECT_EQ(written(binary), ascii);
  EXPECT_LT(binary.size(), ascii.size());
}

TEST(RibWriter, IndentsBlocksAndBreaksLongArrays) {
  EXPECT_EQ(
      written(
          "WorldBegin AttributeBegin Sides 1 IfBegin \"1\" Sides 2 Else Sides 1 IfEnd AttributeEnd WorldEnd"),
      "WorldBegin\n  AttributeBegin\n    Sides 1\n    IfBegin \"1\"\n      Sides 2\n    Else\n      Sides 1\n"
      "    IfEnd\n  AttributeEnd\nWorldEnd\n");
  EXPECT_EQ(written("Polygon \"P\" [0 0 0 1 0 0 1 1 0]", {.lineWidth = 24}),
            "Polygon \"P\" [0 0 0 1 0 0\n    1 1 0]\n");
}

TEST(RibWriter, KeepsOrStripsComments) {
  constexpr std::string_view kRib = "##RenderMan RIB\n#one\nSides 1 #two\nSides 2\n";
  EXPECT_EQ(written(kRib), "##RenderMan RIB\n#one\nSides 1\n#two\nSides 2\n");
  EXPECT_EQ(written(kRib, {.comments = false}), "##RenderMan RIB\nSides 1\nSides 2\n");
  EXPECT_EQ(written(kRib, {.comments = false, .structure = false}), "Sides 1\nSides 2\n");
}

TEST(RibWriter, NumbersKeepTheirBits) {
  std::string rib =
      "Option \"user\" \"float[9] f\" [0.1 -0 1e-45 3.4028235e38 16777217 0.333333343 1e10 -1e-30 "
      "123456.789] "
      "\"int[5] i\" [2147483647 -2147483648 16777217 0 -129]";
  for (const RibEncoding encoding : {RibEncoding::Ascii, RibEncoding::Binary}) {
    struct Values final : RibHandler {
      std::vector<uint32_t> bits;
      std::vector<int> ints;
      void option(std::string_view, const ParamList& params, const Location&) override {
        for (const float f : params.find("f")->floats) bits.push_back(std::bit_cast<uint32_t>(f));
        for (const int i : params.find("i")->ints) ints.push_back(i);
      }
    } before, after;
    ErrorHandler errors([](Severity, std::string_view message) { ADD_FAILURE() << message; });
    RibParser(before, errors).parseMemory(rib, "a");
    RibParser(after, errors).parseMemory(written(rib, {.encoding = encoding}), "b");
    EXPECT_EQ(before.bits.size(), 9u);
    EXPECT_EQ(before.bits, after.bits);
    EXPECT_EQ(before.ints, (std::vector<int>{2147483647, -2147483647 - 1, 16777217, 0, -129}));
    EXPECT_EQ(before.ints, after.ints);
  }
}

TEST(RibWriter, MoreThan256StringsAreDefined) {
  std::string rib;
  for (int round = 0; round < 3; ++round)
    for (int k = 0; k < 700; ++k) rib += fmt::format("CoordinateSystem \"system{}\"\n", k);
  const std::string binary = written(rib, {.encoding = RibEncoding::Binary});
  EXPECT_EQ(recorded(binary), recorded(rib));
  EXPECT_EQ(written(binary), rib);
}

TEST(RibWriter, AFullDiskIsNoticedAndWritingStops) {
  int calls = 0;
  RibWriter writer([&](std::string_view) { return ++calls < 2; });
  for (int k = 0; k < 500000; ++k) writer.sides(1, {});
  EXPECT_FALSE(writer.flush());
  EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace patina::test
