// SPDX-License-Identifier: Apache-2.0
// Names, folding and printing of user errors.
#include "rib/error.h"

#include <cstdio>
#include <unordered_set>

#include <fmt/format.h>

namespace patina {

const std::string* internFileName(std::string_view name) {
  static std::mutex mutex;
  static auto* names =
      new std::unordered_set<std::string>;  // never freed: locations outlive static destructors
  std::lock_guard lock(mutex);
  return &*names->emplace(name).first;
}

std::string toString(const Location& at) {
  if (!at.file) return {};
  if (at.line == 0) return *at.file;
  if (at.column == 0) return fmt::format("{}:{}", *at.file, at.line);
  return fmt::format("{}:{}:{}", *at.file, at.line, at.column);
}

std::string_view name(RiError code) {
  switch (code) {
    case RiError::ArrayTooBig:
      return "arraytoobig";
    case RiError::BadArgument:
      return "badargument";
    case RiError::BadArray:
      return "badarray";
    case RiError::BadBasis:
      return "badbasis";
    case RiError::BadColor:
      return "badcolor";
    case RiError::BadHandle:
      return "badhandle";
    case RiError::BadParamList:
      return "badparamlist";
    case RiError::BadRipCode:
      return "badripcode";
    case RiError::BadStringToken:
      return "badstringtoken";
    case RiError::BadToken:
      return "badtoken";
    case RiError::BadVersion:
      return "badversion";
    case RiError::LimitCheck:
      return "limitcheck";
    case RiError::OutOfMemory:
      return "outofmemory";
    case RiError::ProtocolBotch:
      return "protocolbotch";
    case RiError::StringTooBig:
      return "stringtoobig";
    case RiError::SyntaxError:
      return "syntaxerror";
    case RiError::Unregistered:
      return "unregistered";
    case RiError::NoFile:
      return "nofile";
    case RiError::BadFile:
      return "badfile";
    case RiError::System:
      return "system";
    case RiError::Unimplemented:
      return "unimplemented";
    case RiError::Incapable:
      return "incapable";
    case RiError::Bug:
      return "bug";
    case RiError::Nesting:
      return "nesting";
    case RiError::NotOptions:
      return "notoptions";
    case RiError::NotAttribs:
      return "notattribs";
    case RiError::NotPrims:
      return "notprims";
    case RiError::IllState:
      return "illstate";
    case RiError::BadMotion:
      return "badmotion";
    case RiError::BadSolid:
      return "badsolid";
    case RiError::Range:
      return "range";
    case RiError::Consistency:
      return "consistency";
    case RiError::NoShader:
      return "noshader";
    case RiError::MissingData:
      return "missingdata";
    case RiError::Math:
      return "math";
  }
  return "bug";
}

std::string_view name(Severity severity) {
  switch (severity) {
    case Severity::Info:
      return "info";
    case Severity::Warning:
      return "warning";
    case Severity::Error:
      return "error";
    case Severity::Severe:
      return "severe";
  }
  return "error";
}

namespace {

/// The part of a line around a column (from 1), and a caret under it. Empty for what is no text.
std::string excerpt(std::string_view line, uint32_t column) {
  constexpr size_t kBefore = 60, kWidth = 100;
  const size_t at = column > 0 ? column - 1 : 0;
  if (at > line.size()) return {};
  const size_t first = at > kBefore && line.size() > kWidth ? at - kBefore : 0;
  const std::string_view shown = line.substr(first, kWidth);
  std::string text = "\n  ", caret = "\n  ";
  size_t odd = 0;
  for (size_t k = 0; k < shown.size(); ++k) {
    const auto byte = static_cast<unsigned char>(shown[k]);
    const bool printable = byte >= ' ' && byte != 0177;
    odd += !printable && byte != '\t';
    text += byte == '\t' ? ' ' : printable ? shown[k] : '?';
    // Bytes that continue a character of UTF-8 take no room.
    if (first + k < at && (byte & 0300) != 0200) caret += ' ';
  }
  if (odd * 8 > shown.size()) return {};
  return text + caret + '^';
}

}  // namespace

ErrorHandler::ErrorHandler() : ErrorHandler(Sink{}) {}

ErrorHandler::ErrorHandler(Sink sink) : ErrorHandler(std::move(sink), Limits{}) {}

ErrorHandler::ErrorHandler(Sink sink, Limits limits) : sink_(std::move(sink)), limits_(limits) {
  if (!sink_) {
    sink_ = [](Severity, std::string_view text) {
      fmt::print(stderr, "{}\n", text);
      std::fflush(stderr);
    };
  }
}

void ErrorHandler::report(Severity severity, RiError code, const Location& at, std::string_view message,
                          std::string_view key) {
  add(severity, code, at, message, key.empty() ? message : key, limits_.repeat);
}

void ErrorHandler::reportOnce(Severity severity, RiError code, const Location& at, std::string_view key,
                              std::string_view message) {
  add(severity, code, at, message, key.empty() ? message : key, 1);
}

void ErrorHandler::add(Severity severity, RiError code, const Location& at, std::string_view message,
                       std::string_view key, uint32_t repeat) {
  std::lock_guard lock(mutex_);
  ++counts_[static_cast<size_t>(severity)];
  if (severity >= Severity::Error && style_ == ErrorStyle::Abort) aborted_ = true;

  // Find the group of this message; beyond the limit all new ones share a last, nameless group.
  std::string group = fmt::format("{} {}", name(code), key);
  auto found = index_.find(group);
  if (found == index_.end()) {
    if (entries_.size() >= limits_.kinds) group = "other";
    found = index_.try_emplace(std::move(group), entries_.size()).first;
    if (found->second == entries_.size()) {
      entries_.push_back({0, 0, severity, code, at, std::string(message)});
    }
  }
  Entry& entry = entries_[found->second];
  ++entry.count;

  if (style_ == ErrorStyle::Ignore || severity < lowestPrinted_) {
    entry.printed = entry.count;  // left out on purpose: not to be summed up as folded
    return;
  }
  if (entry.printed >= repeat || printed_ >= limits_.printed) return;
  ++entry.printed;
  ++printed_;
  print(severity, code, at, message);
}

void ErrorHandler::print(Severity severity, RiError code, const Location& at, std::string_view message) {
  const std::string place = toString(at);
  std::string text =
      fmt::format("{}: {}: {}: {}", place.empty() ? "patina" : place, name(severity), name(code), message);
  if (showLines_ && at.line > 0) {
    for (size_t k = texts_.size(); k-- > 0;) {
      if (texts_[k].second != std::this_thread::get_id()) continue;
      if (const auto line = texts_[k].first->line(at)) {
        text += excerpt(*line, at.column);
        break;
      }
    }
  }
  for (const auto& [note, thread] : notes_)
    if (thread == std::this_thread::get_id()) text += "\n  " + *note;
  sink_(severity, text);
}

ErrorHandler::OnBehalf::OnBehalf(ErrorHandler& errors, std::string note)
    : errors_(errors), note_(std::move(note)) {
  const std::lock_guard lock(errors_.mutex_);
  errors_.notes_.emplace_back(&note_, std::this_thread::get_id());
}

ErrorHandler::OnBehalf::~OnBehalf() {
  const std::lock_guard lock(errors_.mutex_);
  std::erase_if(errors_.notes_, [&](const auto& known) { return known.first == &note_; });
}

void ErrorHandler::setShowLines(bool on) {
  std::lock_guard lock(mutex_);
  showLines_ = on;
}

void ErrorHandler::offer(const SourceText& text) {
  std::lock_guard lock(mutex_);
  texts_.emplace_back(&text, std::this_thread::get_id());
}

void ErrorHandler::withdraw(const SourceText& text) {
  std::lock_guard lock(mutex_);
  std::erase_if(texts_, [&](const auto& offered) { return offered.first == &text; });
}

void ErrorHandler::summarize() {
  std::lock_guard lock(mutex_);
  constexpr size_t kLines = 50;  // a summary is for reading
  size_t lines = 0;
  uint64_t further = 0;
  for (Entry& entry : entries_) {
    const uint64_t left = entry.count - entry.printed;
    if (left == 0) continue;
    entry.printed = entry.count;
    if (++lines > kLines) {
      further += left;
      continue;
    }
    sink_(entry.severity, fmt::format("... and {} more of the same: {}: {}: {}", left, name(entry.severity),
                                      name(entry.code), entry.message));
  }
  if (further) sink_(Severity::Warning, fmt::format("... and {} more messages", further));
}

void ErrorHandler::setStyle(ErrorStyle style) {
  std::lock_guard lock(mutex_);
  style_ = style;
}

void ErrorHandler::setQuiet(Severity lowestPrinted) {
  std::lock_guard lock(mutex_);
  lowestPrinted_ = lowestPrinted;
}

uint64_t ErrorHandler::count(Severity severity) const {
  std::lock_guard lock(mutex_);
  return counts_[static_cast<size_t>(severity)];
}

bool ErrorHandler::aborted() const { return aborted_; }

int ErrorHandler::exitStatus() const { return count(Severity::Error) + count(Severity::Severe) > 0 ? 1 : 0; }

}  // namespace patina
