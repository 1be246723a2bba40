// SPDX-License-Identifier: Apache-2.0
// The field of a Blobby: its program, evaluation, bounds and shares.
#include "renderer/geometry/blobby_field.h"

#include <limits>

namespace patina {
namespace {

using Op = BlobbyTape::Op;
using Jet = BlobbyField::Jet;

constexpr double kMost = 1e30;  // values stay within, so that no operation makes an infinity or a NaN
constexpr double kLeastDivisor = 1e-6;
constexpr uint32_t kZero = 0xffffffffu;  // in place of an item: nothing is left of it

double kept(double x) { return std::clamp(x, -kMost, kMost); }
double divisor(double x) { return std::abs(x) < kLeastDivisor ? std::copysign(kLeastDivisor, x) : x; }

/// One operation on numbers. Each is monotonic in either operand where that keeps its sign, also when
/// rounded: the ends of ranges bound what comes of the numbers in them.
double apply(Op op, double a, double b) {
  switch (op) {
    case Op::Add:
      return kept(a + b);
    case Op::Subtract:
      return kept(a - b);
    case Op::Multiply:
      return kept(a * b);
    case Op::Divide:
      return kept(a / divisor(b));
    case Op::Maximum:
      return a > b ? a : b;
    case Op::Minimum:
      return a < b ? a : b;
    case Op::Negate:
      return -a;
    case Op::Zero:
    case Op::Field:
      break;
  }
  return 0;
}

Range apply(Op op, const Range& a, const Range& b) {
  switch (op) {
    case Op::Subtract:
      return {apply(op, a.low, b.high), apply(op, a.high, b.low)};
    case Op::Negate:
      return {-a.high, -a.low};
    case Op::Multiply:
    case Op::Divide: {
      if (op == Op::Divide && b.low < 0 && b.high >= 0) {
        const double most = kept(std::max(std::abs(a.low), std::abs(a.high)) / kLeastDivisor);
        return {-most, most};
      }
      const double ends[4] = {apply(op, a.low, b.low), apply(op, a.low, b.high), apply(op, a.high, b.low),
                              apply(op, a.high, b.high)};
      return {*std::min_element(ends, ends + 4), *std::max_element(ends, ends + 4)};
    }
    default:
      return {apply(op, a.low, b.low), apply(op, a.high, b.high)};
  }
}

Jet apply(Op op, const Jet& a, const Jet& b) {
  const double value = apply(op, a.value, b.value);
  switch (op) {
    case Op::Add:
      return {value, a.gradient + b.gradient};
    case Op::Subtract:
      return {value, a.gradient - b.gradient};
    case Op::Multiply:
      return {value, a.gradient * b.value + b.gradient * a.value};
    case Op::Divide: {
      const double d = divisor(b.value);
      return {value, d == b.value ? (a.gradient - b.gradient * value) / d : a.gradient / d};
    }
    case Op::Maximum:
      return a.value > b.value ? a : b;
    case Op::Minimum:
      return a.value < b.value ? a : b;
    case Op::Negate:
      return {value, -a.gradient};
    case Op::Zero:
    case Op::Field:
      break;
  }
  return {0, V3d(0, 0, 0)};
}

Op operatorOf(Blobby::Op op) {
  switch (op) {
    case Blobby::Op::Multiply:
      return Op::Multiply;
    case Blobby::Op::Maximum:
      return Op::Maximum;
    case Blobby::Op::Minimum:
      return Op::Minimum;
    case Blobby::Op::Subtract:
      return Op::Subtract;
    case Blobby::Op::Divide:
      return Op::Divide;
    case Blobby::Op::Negate:
      return Op::Negate;
    default:
      return Op::Add;
  }
}

bool isUnary(Op op) { return op == Op::Negate; }
bool isLeaf(Op op) { return op == Op::Zero || op == Op::Field; }

/// Keeps the items that the one at `root` needs, in their order. `places` is memory.
void compact(std::vector<BlobbyTape::Item>& items, uint32_t root, std::vector<uint32_t>& places) {
  if (root == kZero) return items.clear();
  items.resize(root + 1);
  places.assign(items.size(), 0);
  places[root] = 1;
  for (size_t k = items.size(); k-- > 0;) {
    if (places[k] == 0 || isLeaf(items[k].op)) continue;
    places[items[k].a] = 1;
    if (!isUnary(items[k].op)) places[items[k].b] = 1;
  }
  uint32_t count = 0;
  for (size_t k = 0; k < items.size(); ++k) {
    if (places[k] == 0) continue;
    BlobbyTape::Item item = items[k];
    if (!isLeaf(item.op)) {
      item.a = places[item.a];
      if (!isUnary(item.op)) item.b = places[item.b];
    }
    items[count] = item;
    places[k] = count++;
  }
  items.resize(count);
}

}  // namespace

BlobbyField::BlobbyField(const Blobby& blobby, size_t& spoiled) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (Range& axis : support_.axis) axis = {kInf, -kInf};
  // Operators of many operands become chains of two.
  std::vector<uint32_t> place;  // of each instruction's result
  place.reserve(blobby.instructions.size());
  uint32_t number = 0;
  const auto push = [&](Op op, uint32_t a, uint32_t b) {
    tape_.items.push_back({op, a, b});
    return static_cast<uint32_t>(tape_.items.size() - 1);
  };
  spoiled = 0;
  for (const Blobby::Instruction& instruction : blobby.instructions) {
    if (instruction.isField()) {
      const bool good = addLeaf(blobby, instruction, number++);
      if (!good) ++spoiled;
      place.push_back(good ? push(Op::Field, static_cast<uint32_t>(leaves_.size() - 1), 0)
                           : push(Op::Zero, 0, 0));
      continue;
    }
    const Op op = operatorOf(instruction.op);
    uint32_t result = place[blobby.operands[instruction.first]];
    if (isUnary(op)) result = push(op, result, 0);
    for (uint32_t k = 1; k < instruction.count; ++k)
      result = push(op, result, place[blobby.operands[instruction.first + k]]);
    place.push_back(result);
  }
  std::vector<uint32_t> places;
  compact(tape_.items, place.empty() ? kZero : place.back(), places);
}

std::vector<BlobbyField::Detail> BlobbyField::details() const {
  std::vector<Detail> details;
  for (const Leaf& leaf : leaves_)
    if (leaf.kind == Kind::Ellipsoid || leaf.kind == Kind::Segment) details.push_back(leaf.detail);
  return details;
}

void BlobbyField::forward(const BlobbyTape& tape, const V3d& p, std::vector<double>& values) const {
  values.resize(tape.items.size());
  for (size_t k = 0; k < tape.items.size(); ++k) {
    const BlobbyTape::Item& item = tape.items[k];
    values[k] = item.op == Op::Field  ? value(leaves_[item.a], p)
                : item.op == Op::Zero ? 0
                                      : apply(item.op, values[item.a], values[item.b]);
  }
}

double BlobbyField::value(const BlobbyTape& tape, const V3d& p, Scratch& scratch) const {
  forward(tape, p, scratch.values);
  return tape.items.empty() ? 0 : scratch.values.back();
}

BlobbyField::Jet BlobbyField::jet(const BlobbyTape& tape, const V3d& p, Scratch& scratch) const {
  std::vector<Jet>& jets = scratch.jets;
  jets.resize(tape.items.size());
  for (size_t k = 0; k < tape.items.size(); ++k) {
    const BlobbyTape::Item& item = tape.items[k];
    jets[k] = item.op == Op::Field  ? jet(leaves_[item.a], p)
              : item.op == Op::Zero ? Jet{0, V3d(0, 0, 0)}
                                    : apply(item.op, jets[item.a], jets[item.b]);
  }
  return tape.items.empty() ? Jet{0, V3d(0, 0, 0)} : jets.back();
}

Range BlobbyField::restrict(const BlobbyTape& tape, const BlobbyBox& box, BlobbyTape& part,
                            Scratch& scratch) const {
  // places: the item of `part` that has the value of an item of `tape`, or kZero.
  std::vector<Range>& ranges = scratch.ranges;
  std::vector<uint32_t>& places = scratch.places;
  const size_t count = tape.items.size();
  ranges.resize(count);
  places.resize(count);
  part.items.clear();
  const auto push = [&](Op op, uint32_t a, uint32_t b) {
    part.items.push_back({op, a, b});
    return static_cast<uint32_t>(part.items.size() - 1);
  };
  const auto written = [&](uint32_t place) { return place == kZero ? push(Op::Zero, 0, 0) : place; };
  for (size_t k = 0; k < count; ++k) {
    const BlobbyTape::Item& item = tape.items[k];
    if (isLeaf(item.op)) {
      ranges[k] = item.op == Op::Field ? range(leaves_[item.a], box) : Range{0, 0};
      places[k] = ranges[k].low == 0 && ranges[k].high == 0 ? kZero : push(item.op, item.a, item.b);
      continue;
    }
    const uint32_t second = isUnary(item.op) ? item.a : item.b;
    const Range &ra = ranges[item.a], &rb = ranges[second];
    const uint32_t a = places[item.a], b = places[second];
    ranges[k] = apply(item.op, ra, rb);
    uint32_t& place = places[k];
    const auto whole = [&] {
      const uint32_t first = written(a);
      return push(item.op, first, isUnary(item.op) ? 0 : written(b));
    };
    switch (item.op) {
      case Op::Add:
        place = a == kZero ? b : b == kZero ? a : whole();
        break;
      case Op::Subtract:
        place = b == kZero ? a : whole();
        break;
      case Op::Multiply:
        place = a == kZero || b == kZero ? kZero : whole();
        break;
      case Op::Divide:
      case Op::Negate:
        place = a == kZero ? kZero : whole();
        break;
      case Op::Maximum:
        place = ra.low >= rb.high ? a : rb.low >= ra.high ? b : whole();
        break;
      case Op::Minimum:
        place = ra.high <= rb.low ? a : rb.high <= ra.low ? b : whole();
        break;
      case Op::Zero:
      case Op::Field:
        break;
    }
    if (place == kZero) ranges[k] = {0, 0};
  }
  if (count == 0) return {0, 0};
  const Range result = ranges[count - 1];
  compact(part.items, places[count - 1], places);
  return result;
}

void BlobbyField::weights(const BlobbyTape& tape, const V3d& p, Scratch& scratch,
                          std::vector<LeafWeight>& out) const {
  out.clear();
  std::vector<double>& values = scratch.values;
  forward(tape, p, values);
  const size_t count = values.size();
  if (count == 0) return;
  values.resize(2 * count);  // the second half: shares
  double* const share = values.data() + count;
  std::fill_n(share, count, 0.0);
  share[count - 1] = 1;
  double total = 0;
  for (size_t k = count; k-- > 0;) {
    const BlobbyTape::Item& item = tape.items[k];
    const double s = share[k];
    if (s == 0) continue;
    switch (item.op) {
      case Op::Field:
        out.push_back({leaves_[item.a].number, static_cast<float>(s)});
        total += s;
        break;
      case Op::Add:
      case Op::Multiply: {
        const double a = std::max(values[item.a], 0.0), b = std::max(values[item.b], 0.0);
        const double part = a + b > 0 ? a / (a + b) : 0.5;
        share[item.a] += s * part;
        share[item.b] += s * (1 - part);
        break;
      }
      case Op::Maximum:
        share[values[item.a] > values[item.b] ? item.a : item.b] += s;
        break;
      case Op::Minimum:
        share[values[item.a] < values[item.b] ? item.a : item.b] += s;
        break;
      case Op::Subtract:
      case Op::Divide:
        share[item.a] += s;
        break;
      case Op::Zero:
      case Op::Negate:
        break;
    }
  }
  for (LeafWeight& w : out) w.weight = static_cast<float>(static_cast<double>(w.weight) / total);
}

}  // namespace patina
