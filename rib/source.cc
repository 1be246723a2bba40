// SPDX-License-Identifier: Apache-2.0
// Mapping, slurping and inflating of inputs; counting of lines.
#include "rib/source.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <zlib.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include "rib/parser.h"

namespace patina {
namespace {

// A block of malloc'd bytes that grows by doubling; large blocks are moved by remapping pages, not by
// copying.
class GrowingBytes {
 public:
  GrowingBytes() = default;
  GrowingBytes(const GrowingBytes&) = delete;
  GrowingBytes& operator=(const GrowingBytes&) = delete;
  ~GrowingBytes() { std::free(data_); }

  // At least `more` free bytes behind the used ones; false = out of memory.
  bool reserve(size_t more) {
    if (capacity_ - size_ >= more) return true;
    const size_t wanted = std::max(capacity_ * 2, size_ + more);
    void* grown = std::realloc(data_, wanted);
    if (!grown) return false;
    data_ = static_cast<char*>(grown);
    capacity_ = wanted;
    return true;
  }
  char* free() { return data_ + size_; }
  size_t room() const { return capacity_ - size_; }
  void use(size_t bytes) { size_ += bytes; }
  size_t size() const { return size_; }
  char* take() { return std::exchange(data_, nullptr); }

 private:
  char* data_ = nullptr;
  size_t size_ = 0, capacity_ = 0;
};

constexpr size_t kBlock = size_t{1} << 18;

std::string systemReason() { return std::strerror(errno); }

}  // namespace

Source& Source::operator=(Source&& other) noexcept {
  if (this != &other) {
    release();
    text_ = std::exchange(other.text_, {});
    mapping_ = std::exchange(other.mapping_, nullptr);
    memory_ = std::exchange(other.memory_, nullptr);
    mappedBytes_ = std::exchange(other.mappedBytes_, 0);
  }
  return *this;
}

Source::~Source() { release(); }

void Source::release() {
  if (mapping_) munmap(mapping_, mappedBytes_);
  std::free(memory_);
  mapping_ = nullptr;
  memory_ = nullptr;
  text_ = {};
}

bool Source::openFile(const std::string& path, const ParserLimits& limits, ErrorHandler& errors) {
  const Location at{internFileName(path == "-" ? "<stdin>" : path)};
  if (path == "-") return readDescriptor(STDIN_FILENO, at, limits, errors);
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    errors.report(Severity::Error, RiError::NoFile, at, fmt::format("cannot open: {}", systemReason()));
    return false;
  }
  const bool read = readDescriptor(descriptor, at, limits, errors);
  close(descriptor);
  return read;
}

bool Source::readDescriptor(int descriptor, const Location& at, const ParserLimits& limits,
                            ErrorHandler& errors) {
  release();

  // A regular file at its beginning is mapped.
  struct stat status;
  const bool regular = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  if (regular && status.st_size > 0 && lseek(descriptor, 0, SEEK_CUR) == 0) {
    const auto bytes = static_cast<size_t>(status.st_size);
    void* mapping = mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (mapping != MAP_FAILED) {
      madvise(mapping, bytes, MADV_SEQUENTIAL);
      mapping_ = mapping;
      mappedBytes_ = bytes;
      text_ = {static_cast<const char*>(mapping), bytes};
      return inflateIfGzip(at, limits, errors);
    }
  }

  // Anything else is read to its end, or to the limit.
  GrowingBytes bytes;
  bool complete = false;
  while (!complete) {
    if (!bytes.reserve(kBlock)) {
      errors.report(Severity::Error, RiError::OutOfMemory, at,
                    fmt::format("no memory for more than {} bytes of input", bytes.size()));
      break;
    }
    const ssize_t got = read(descriptor, bytes.free(), bytes.room());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      errors.report(Severity::Error, RiError::BadFile, at, fmt::format("cannot read: {}", systemReason()));
      break;
    }
    complete = got == 0;
    bytes.use(static_cast<size_t>(got));
    if (bytes.size() > limits.inputBytes) {
      errors.report(Severity::Error, RiError::LimitCheck, at,
                    fmt::format("more than {} bytes of input; the rest is ignored", limits.inputBytes));
      break;
    }
  }
  text_ = {nullptr, bytes.size()};
  memory_ = bytes.take();
  text_ = {memory_, std::min<size_t>(text_.size(), limits.inputBytes)};
  return inflateIfGzip(at, limits, errors) && complete;
}

bool Source::viewMemory(std::string_view text, const Location& at, const ParserLimits& limits,
                        ErrorHandler& errors) {
  release();
  text_ = text;
  return inflateIfGzip(at, limits, errors);
}

bool Source::inflateIfGzip(const Location& at, const ParserLimits& limits, ErrorHandler& errors) {
  if (!text_.starts_with("\x1f\x8b")) return true;
  GrowingBytes bytes;
  std::string trouble;
  RiError code = RiError::BadFile;
  z_stream stream{};
  constexpr int kGzipOnly = 16 + MAX_WBITS;
  if (inflateInit2(&stream, kGzipOnly) != Z_OK) trouble = "cannot start to inflate";
  const char* next = text_.data();
  const char* const end = next + text_.size();
  bool inMember = true;
  while (trouble.empty() && (inMember || std::string_view(next, end).starts_with("\x1f\x8b"))) {
    // The next of several members.
    if (!inMember) inflateReset(&stream);
    if (!bytes.reserve(kBlock)) {
      code = RiError::OutOfMemory;
      trouble = fmt::format("no memory for more than {} inflated bytes", bytes.size());
      break;
    }
    const size_t in = std::min<size_t>(static_cast<size_t>(end - next), size_t{1} << 30);
    const size_t out = std::min<size_t>(bytes.room(), size_t{1} << 30);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(next));
    stream.avail_in = static_cast<uInt>(in);
    stream.next_out = reinterpret_cast<Bytef*>(bytes.free());
    stream.avail_out = static_cast<uInt>(out);
    const int result = inflate(&stream, Z_NO_FLUSH);
    next += in - stream.avail_in;
    bytes.use(out - stream.avail_out);
    inMember = result != Z_STREAM_END;
    if (inMember && result != Z_OK) {
      const bool cut = result == Z_BUF_ERROR;
      trouble =
          fmt::format("damaged gzip data ({}); what came before is used", cut          ? "it ends too early"
                                                                          : stream.msg ? stream.msg
                                                                                       : "no reason known");
    }
    // A bomb inflates without end.
    const bool bomb =
        bytes.size() > limits.inflateFreely && bytes.size() / text_.size() >= limits.inflateRatio;
    if (bomb || bytes.size() > limits.inputBytes) {
      code = RiError::LimitCheck;
      trouble = fmt::format("{} gzipped bytes inflate to more than {}; the rest is ignored", text_.size(),
                            bytes.size());
    }
  }
  inflateEnd(&stream);
  if (!trouble.empty()) errors.report(Severity::Error, code, at, trouble);
  const size_t size = bytes.size();
  release();
  memory_ = bytes.take();
  text_ = {memory_, size};
  return trouble.empty();
}

Location LineMap::locate(const char* p) {
  Point at = p >= last_.p ? last_ : mark_;
  const char* lineBegin = nullptr;  // of p's line, if it begins behind `at`
  const char* q = at.p;
  const auto pass = [&](const char* block, uint64_t newlines) {  // a bit for each byte of the block
    if (newlines == 0) return;
    at.line += static_cast<uint32_t>(std::popcount(newlines));
    lineBegin = block + std::bit_width(newlines);
  };
#ifdef __SSE2__
  // Sixteen bytes at a time, those behind p left out: a location is asked for each few bytes of a file.
  for (; q < p && end_ - q >= 16; q += 16) {
    const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(q));
    auto newlines = static_cast<uint32_t>(_mm_movemask_epi8(_mm_cmpeq_epi8(bytes, _mm_set1_epi8('\n'))));
    if (p - q < 16) newlines &= (1u << (p - q)) - 1;
    pass(q, newlines);
  }
#endif
  for (; q < p; ++q) pass(q, *q == '\n');
  at.column =
      lineBegin ? static_cast<uint32_t>(p - lineBegin) + 1 : at.column + static_cast<uint32_t>(p - at.p);
  at.p = p;
  last_ = at;
  return {file_, at.line, at.column};
}

}  // namespace patina
