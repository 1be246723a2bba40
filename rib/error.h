// SPDX-License-Identifier: Apache-2.0
// User errors of the whole renderer: where they are, what kind they are, and the one handler they all go to.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <vector>

namespace patina {

// A place in a RIB file. `line` and `column` count from 1 (column in bytes); 0 = unknown. `file` is interned:
// it lives as long as the process and equal names have equal pointers; null = no file.
struct Location {
  const std::string* file = nullptr;
  uint32_t line = 0;
  uint32_t column = 0;

  bool operator==(const Location&) const = default;
};

// The process-lifetime copy of `name`. [any thread]
const std::string* internFileName(std::string_view name);

// "file:line:column", with the parts that are unknown left out; empty without a file.
std::string toString(const Location& at);

enum class Severity : uint8_t { Info, Warning, Error, Severe };

// The RIB error names (RI 3.2 table C.2) and the RIE codes of the C binding that have no RIB name.
enum class RiError : uint8_t {
  ArrayTooBig,
  BadArgument,
  BadArray,
  BadBasis,
  BadColor,
  BadHandle,
  BadParamList,
  BadRipCode,
  BadStringToken,
  BadToken,
  BadVersion,
  LimitCheck,
  OutOfMemory,
  ProtocolBotch,
  StringTooBig,
  SyntaxError,
  Unregistered,
  NoFile,
  BadFile,
  System,
  Unimplemented,
  Incapable,
  Bug,
  Nesting,
  NotOptions,
  NotAttribs,
  NotPrims,
  IllState,
  BadMotion,
  BadSolid,
  Range,
  Consistency,
  NoShader,
  MissingData,
  Math
};

std::string_view name(RiError code);       // "badargument", ...
std::string_view name(Severity severity);  // "info", "warning", "error", "severe"

enum class ErrorStyle : uint8_t { Ignore, Print, Abort };

// Text that the locations of a file point into: what is being parsed. Asked from the thread that reports.
class SourceText {
 public:
  virtual ~SourceText() = default;
  // The line of `at` without its end; nullopt if it is not in this text.
  virtual std::optional<std::string_view> line(const Location& at) const = 0;
};

// Prints and counts user errors. Every method may be called from any thread. A message is printed as
//   file:line:column: error: badargument: text
// Messages with the same code and key are printed `repeatLimit` times and then only counted; summarize() says
// how often each was left out. Nothing is printed when all is well.
class ErrorHandler {
 public:
  // Gets one whole message without a line end. Called with a lock held: it must not report.
  using Sink = std::function<void(Severity, std::string_view)>;

  struct Limits {
    uint32_t repeat = 3;      // printings per (code, key)
    uint32_t printed = 1000;  // printings in all; beyond that messages are only counted
    uint32_t kinds = 10000;   // different (code, key) pairs remembered, so that memory is bounded
  };

  ErrorHandler();  // prints to standard error
  explicit ErrorHandler(Sink sink);
  ErrorHandler(Sink sink, Limits limits);
  ErrorHandler(const ErrorHandler&) = delete;
  ErrorHandler& operator=(const ErrorHandler&) = delete;

  // `key` groups repetitions; empty = the message itself.
  void report(Severity severity, RiError code, const Location& at, std::string_view message,
              std::string_view key = {});
  // As report(), but printed only the first time; for 'this request is ignored' and the like.
  void reportOnce(Severity severity, RiError code, const Location& at, std::string_view key,
                  std::string_view message);

  // Prints how often each folded message came ("... and 37 more of the same"), once per message. Call at the
  // end.
  void summarize();

  // RI ErrorHandler "ignore" | "print" | "abort". Ignore still counts. Abort: aborted() from the first error
  // on.
  void setStyle(ErrorStyle style);
  // Whether messages show the line of the file that they are about, as far as its text is on offer, with a
  // caret under the place: as further lines of the message. Off by default.
  void setShowLines(bool on);
  // A text stays on offer until it is withdrawn, in the reverse order, by the thread that offered it.
  void offer(const SourceText& text);
  void withdraw(const SourceText& text);

  // While it lives, every message that its thread reports gets a further line: on whose behalf the work is
  // done.
  class OnBehalf {
   public:
    OnBehalf(ErrorHandler& errors, std::string note);
    ~OnBehalf();
    OnBehalf(const OnBehalf&) = delete;
    OnBehalf& operator=(const OnBehalf&) = delete;

   private:
    ErrorHandler& errors_;
    const std::string note_;
  };
  // Nothing below `severity` is printed (it is still counted). Default: Warning, so that Info is silent.
  void setQuiet(Severity lowestPrinted);

  uint64_t count(Severity severity) const;
  // True once an Error or Severe was reported while the style is Abort. The parser and the renderer stop
  // then.
  bool aborted() const;
  // 0 = all well, 1 = at least one Error or Severe.
  int exitStatus() const;

 private:
  struct Entry {
    uint64_t count = 0, printed = 0;
    Severity severity = Severity::Info;
    RiError code = RiError::Bug;
    Location first;
    std::string message;  // the first one's text
  };

  void add(Severity, RiError, const Location&, std::string_view message, std::string_view key,
           uint32_t repeat);
  void print(Severity, RiError, const Location&, std::string_view message);

  mutable std::mutex mutex_;
  Sink sink_;
  Limits limits_;
  ErrorStyle style_ = ErrorStyle::Print;
  Severity lowestPrinted_ = Severity::Warning;
  std::array<uint64_t, 4> counts_{};
  uint64_t printed_ = 0;
  std::atomic<bool> aborted_ = false;
  std::unordered_map<std::string, size_t> index_;  // code + key -> entries_
  std::vector<Entry> entries_;                     // in the order of first appearance
  bool showLines_ = false;
  std::vector<std::pair<const SourceText*, std::thread::id>> texts_;
  std::vector<std::pair<const std::string*, std::thread::id>> notes_;
};

}  // namespace patina
