// SPDX-License-Identifier: Apache-2.0
// Blobby: the code array becomes a checked program.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

using Op = Blobby::Op;

/// 4 divides and 5 subtracts: so Aqsis reads them, and files in use (prman_sub.rib) are written. Texts that
/// have them the other way round exist.
struct OpCode {
  int code;
  Op op;
  const char* name;
  int operands;     ///< -1: the first is their number
  uint32_t floats;  ///< behind the index that is the (last) operand
};
constexpr OpCode kOpCodes[] = {
    {0, Op::Add, "add", -1, 0},
    {1, Op::Multiply, "multiply", -1, 0},
    {2, Op::Maximum, "maximum", -1, 0},
    {3, Op::Minimum, "minimum", -1, 0},
    {4, Op::Divide, "divide", 2, 0},
    {5, Op::Subtract, "subtract", 2, 0},
    {6, Op::Negate, "negate", 1, 0},
    {7, Op::Identity, "identity", 1, 0},
    {1000, Op::Constant, "constant", 1, 1},
    {1001, Op::Ellipsoid, "ellipsoid", 1, 16},
    {1002, Op::Segment, "segment", 1, 23},
    {1003, Op::Plane, "repelling plane", 2, 4},
};

/// Reads the code array; `problem` says why it stopped.
class CodeReader {
 public:
  CodeReader(Ints codes, Floats floats, Strings strings) : codes_(codes), strings_(strings.size()) {
    blobby_.floats.assign(floats.begin(), floats.end());
  }

  bool read() {
    if (codes_.empty()) return fail("its code array is empty");
    while (at_ < codes_.size())
      if (!instruction()) return false;
    return true;
  }

  Blobby& blobby() { return blobby_; }
  const std::string& problem() const { return problem_; }
  size_t fields() const { return fields_; }
  int unknownField() const { return unknownField_; }  ///< 0 = none
  bool depthFile() const { return depthFile_; }

 private:
  bool fail(std::string why) {
    problem_ = std::move(why);
    return false;
  }

  bool instruction() {
    const size_t number = blobby_.instructions.size();
    const int code = codes_[at_];
    const auto* const known = std::ranges::find(kOpCodes, code, &OpCode::code);
    if (known == std::end(kOpCodes)) {
      if (code >= 1000) unknownField_ = code;
      return fail(fmt::format("instruction {} has opcode {}, expected 0 to 7 or 1000 to 1003", number, code));
    }
    const auto where = [&] { return fmt::format("instruction {} ({})", number, known->name); };
    ++at_;
    size_t count = static_cast<size_t>(std::max(known->operands, 0));
    if (known->operands < 0) {
      if (at_ == codes_.size() || codes_[at_] < 1)
        return fail(fmt::format("{} has no operands, expected their number, at least 1", where()));
      count = static_cast<size_t>(codes_[at_++]);
    }
    if (count > codes_.size() - at_)
      return fail(fmt::format("{} wants {} operands, the code array has {} more", where(), count,
                              codes_.size() - at_));
    const Ints operands = codes_.subspan(at_, count);
    at_ += count;
    return known->floats > 0 ? field(*known, operands, where) : combination(*known, operands, number, where);
  }

  template <class Where>
  bool field(const OpCode& known, Ints operands, const Where& where) {
    const int first = operands.back();
    if (first < 0 || static_cast<size_t>(first) > blobby_.floats.size() ||
        blobby_.floats.size() - static_cast<size_t>(first) < known.floats)
      return fail(fmt::format("{} wants {} floats from number {}, there are {}", where(), known.floats, first,
                              blobby_.floats.size()));
    if (known.op == Op::Plane) {
      if (operands[0] < 0 || (static_cast<size_t>(operands[0]) >= strings_ && strings_ > 0))
        return fail(fmt::format("{} wants string number {}, there are {}", where(), operands[0], strings_));
      depthFile_ = true;
    }
    blobby_.instructions.push_back({known.op, static_cast<uint32_t>(first), known.floats});
    ++fields_;
    return true;
  }

  template <class Where>
  bool combination(const OpCode& known, Ints operands, size_t number, const Where& where) {
    const size_t first = blobby_.operands.size();
    for (const int operand : operands) {
      if (operand < 0 || static_cast<size_t>(operand) >= number)
        return fail(fmt::format("{} has operand {}, expected the number of an earlier instruction", where(),
                                operand));
      blobby_.operands.push_back(static_cast<uint32_t>(operand));
    }
    blobby_.instructions.push_back(
        {known.op, static_cast<uint32_t>(first), static_cast<uint32_t>(operands.size())});
    return true;
  }

  Ints codes_;
  size_t strings_, at_ = 0, fields_ = 0;
  int unknownField_ = 0;
  bool depthFile_ = false;
  Blobby blobby_;
  std::string problem_;
};

}  // namespace

void SceneBuilder::blobby(int leaves, Ints codes, Floats floats, Strings strings, const ParamList& params,
                          const Location& at) {
  if (!mayDraw(at)) return;
  if (leaves < 0)
    return error(RiError::Range, at,
                 fmt::format("Blobby is left out: {} leaves, expected 0 or more", leaves));
  if (const auto bad = std::ranges::find_if(floats, [](float f) { return !std::isfinite(f); });
      bad != floats.end())
    return error(RiError::Range, at,
                 fmt::format("Blobby is left out: float number {} is not finite", bad - floats.begin()));
  CodeReader reader(codes, floats, strings);
  if (!reader.read()) {
    if (reader.unknownField() > 0)
      return warning(RiError::Unimplemented, at, fmt::format("Blobby is left out: {}", reader.problem()),
                     "Blobby field");
    return error(RiError::BadArgument, at, fmt::format("Blobby is left out: {}", reader.problem()));
  }
  // Pixar's own example of a hand has one field more than it says.
  if (static_cast<size_t>(leaves) != reader.fields())
    warning(
        RiError::Consistency, at,
        fmt::format("Blobby has {} leaves, its code has {} fields; the code holds", leaves, reader.fields()),
        "Blobby leaves");
  if (reader.depthFile())
    warning(RiError::Unimplemented, at,
            "Blobby: depth files of repelling planes are not read; the plane z = 0 takes their place",
            "Blobby depth file");
  reader.blobby().leaves = static_cast<size_t>(leaves);
  addPrimitive(std::move(reader.blobby()), params, at);
}

}  // namespace patina
