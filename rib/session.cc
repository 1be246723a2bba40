// SPDX-License-Identifier: Apache-2.0
// Requests from first word to handler: values, errors, skipped branches, recorded archives.
#include "rib/session.h"

#include <new>
#include <utility>

#include <fmt/format.h>

#include "rib/arguments.h"

namespace patina {

ParseSession::ParseSession(RibParser& parser, ValuePool& pool, std::string_view text, const Location& start,
                           std::shared_ptr<EncodingTables> tables)
    : parser_(parser),
      pool_(pool),
      text_(text),
      start_(start),
      lines_(text, start),
      tables_(std::move(tables)) {}

std::optional<std::string_view> ParseSession::line(const Location& at) const {
  if (at.file != start_.file || at.line < start_.line) return std::nullopt;
  std::string_view rest = text_;
  for (uint32_t number = start_.line;; ++number) {
    const size_t end = std::min(rest.find('\n'), rest.size());
    // The text of an inline archive begins within its first line.
    if (number == at.line && number == start_.line && start_.column > 1) return std::nullopt;
    if (number == at.line) return rest.substr(0, end - (end > 0 && rest[end - 1] == '\r' ? 1 : 0));
    if (end == rest.size()) return std::nullopt;
    rest.remove_prefix(end + 1);
  }
}

bool ParseSession::run() {
  struct Offer {
    ErrorHandler& errors;
    const SourceText& text;
    ~Offer() { errors.withdraw(text); }
  };
  errors().offer(*this);
  const Offer offer{errors(), *this};
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  std::string_view rest = text_;
  if (rest.starts_with(kByteOrderMark)) rest.remove_prefix(kByteOrderMark.size());
  pool_.clear();
  try {
    if (!rest.empty()) parseRib(rest.data(), rest.data() + rest.size(), *this);
  } catch (const std::bad_alloc&) {
    errors().report(Severity::Severe, RiError::OutOfMemory, at_,
                    fmt::format("no memory for the values of {}", name_));
    return false;
  }
  if (stopped_) return false;

  // What is still open at the end?
  if (recordDepth_ > 0) {
    errors().report(Severity::Error, RiError::Nesting, recordAt_,
                    fmt::format("ArchiveBegin \"{}\" has no ArchiveEnd", recordName_), "unclosed archive");
  }
  if (!conditions_.empty()) {
    errors().report(Severity::Error, RiError::Nesting, conditions_.back().at, "IfBegin has no IfEnd");
  }
  return !errors().aborted();
}

void ParseSession::error(RiError code, const char* p, std::string_view message, std::string_view key) {
  // The first error of a request is the one to mend; what follows is often its echo.
  if (reported_ || quiet()) return;
  reported_ = true;
  const std::string text =
      inRequest_ && !name_.empty() ? fmt::format("{}: {}", name_, message) : std::string(message);
  errors().report(Severity::Error, code, lines_.locate(p), text, key);
}

void ParseSession::fatal(RiError code, const char* p, std::string_view message, std::string_view key) {
  error(code, p, message, key);
  failed_ = true;
}

void ParseSession::spoilArray() {
  if (!pool_.values.empty()) pool_.values.back().bad = true;
}

void ParseSession::addNumbers(size_t first, const char* begin, const char* end, bool bad) {
  const size_t count = pool_.floats.size() - first;
  auto& values = pool_.values;
  const bool continues = !values.empty() && values.back().kind == Value::Kind::Number && !values.back().array;
  if (!inArray_ && !continues) values.push_back({Value::Kind::Number, false, false, first, 0, begin, end});
  Value& value = values.back();
  if (value.kind == Value::Kind::Empty) {
    value.kind = Value::Kind::Number;
    value.first = first;
  } else if (value.kind == Value::Kind::String) {
    value.kind = Value::Kind::Mixed;
  }
  value.count += count;
  value.bad |= bad;
  value.end = end;
}

void ParseSession::addString(std::string_view text, const char* begin, const char* end) {
  const size_t first = pool_.strings.size();
  pool_.strings.push_back(text);
  if (!inArray_) {
    pool_.values.push_back({Value::Kind::String, false, false, first, 1, begin, end});
    return;
  }
  Value& value = pool_.values.back();
  if (value.kind == Value::Kind::Empty) {
    value.kind = Value::Kind::String;
    value.first = first;
  } else if (value.kind == Value::Kind::Number) {
    value.kind = Value::Kind::Mixed;
  }
  ++value.count;
}

void ParseSession::beginArray(const char* p) {
  if (inArray_) {
    error(RiError::BadArray, p - 1, "an array within an array");
    spoilArray();
    return;
  }
  inArray_ = true;
  pool_.values.push_back({Value::Kind::Empty, true, false, 0, 0, p - 1, p});
}

void ParseSession::endArray(const char* p, bool closed) {
  inArray_ = false;
  Value& array = pool_.values.back();
  array.end = p;
  if (closed) return;
  fatal(RiError::SyntaxError, array.begin, "array begun here is not closed by ']'", "unclosed array");
}

bool ParseSession::beginStray(const char* p) {
  if (stopped_ || p == text_.data() + text_.size()) return false;
  pool_.clear();
  reported_ = failed_ = false;
  lines_.mark(p);
  error(RiError::SyntaxError, p, "a request is expected here");
  return true;
}

void ParseSession::beginRequest() {
  pool_.clear();
  retired_.clear();
  reported_ = failed_ = false;
  inRequest_ = true;
  at_ = lines_.mark(nameBegin_);
  request_ = findRibRequest(name_);
  if (request_) return;
  // Text that is no RIB at all is one error, not one for each of its words.
  if (!afterUnknown_) reportUnknown();
  reported_ = true;
}

bool ParseSession::endRequest() {
  carryOut();
  inRequest_ = false;
  deliverComments();
  stopped_ = errors().aborted();
  return !stopped_;
}

void ParseSession::carryOut() {
  if (recordDepth_ > 0) return record();
  if (!delivering()) {
    if (name_ == "IfBegin") conditions_.push_back({at_, false, false, false, true});
    if (name_ != "ElseIf" && name_ != "Else" && name_ != "IfEnd") return;
  }
  afterUnknown_ = !request_ && pool_.values.empty();
  if (!request_) return;
  // A request without arguments is carried out whatever stands behind it: the nesting depends on it.
  if (failed_ && !request_->usage.empty() && name_ != "IfBegin" && name_ != "ElseIf") return;
  if (!parser_.handler_.wants(request_->name, at_)) return;
  Arguments arguments(*this);
  request_->call(arguments);
}

void ParseSession::reportUnknown() {
  inRequest_ = false;  // the message names the request itself
  if (name_.empty() && nameBegin_ + 1 == text_.data() + text_.size()) {
    truncated(nameBegin_, "request code", nullptr);
  } else if (name_.empty()) {
    error(RiError::BadRipCode, nameBegin_, "request code is not defined");
  } else {
    const std::string_view near = firstTime(name_) ? nearestRibRequest(name_) : std::string_view();
    const std::string hint = near.empty() ? std::string() : fmt::format(" (did you mean {}?)", near);
    error(RiError::Unregistered, nameBegin_, fmt::format("unknown request {}{}", name_.substr(0, 80), hint));
  }
  inRequest_ = true;
}

void ParseSession::deliverComments() {
  for (const ValuePool::Comment& comment : pool_.comments) {
    const Location at = lines_.locate(comment.begin);
    const std::string_view text(comment.begin + 1, static_cast<size_t>(comment.end - comment.begin) - 1);
    if (text.starts_with('#')) {
      handler().structure(text.substr(1), at);
    } else {
      handler().comment(text, at);
    }
  }
  pool_.comments.clear();
}

void ParseSession::archiveBegin(std::string_view name, const ParamList& params) {
  if (!handler().archiveBegin(name, params, at_)) return;
  recordDepth_ = 1;
  recordAt_ = at_;
  recordName_ = name;
  recordBegin_ = pool_.values.back().end;
  recordTextAt_ = lines_.locate(recordBegin_);
  recordTables_ = tables_;
  pool_.comments.clear();  // those behind the request are part of the recorded text
}

void ParseSession::record() {
  if (name_ == "ArchiveBegin") ++recordDepth_;
  if (name_ != "ArchiveEnd" || --recordDepth_ > 0) return;
  InlineArchive archive;
  archive.text = std::make_shared<const std::string>(recordBegin_, nameBegin_);
  archive.tables = std::exchange(recordTables_, nullptr);
  archive.start = recordTextAt_;
  handler().archive(recordName_, std::move(archive), at_);
}

void ParseSession::setBranch(Branch branch) {
  Condition& condition = conditions_.back();
  condition.deliver = branch != Branch::Skip;
  condition.taken |= condition.deliver;
  condition.all = branch == Branch::All;
}

void ParseSession::ifBegin(std::string_view test, const ParamList& params, bool valid) {
  // Without a condition nobody knows which branch is meant: all are skipped, and the handler hears of none.
  if (!valid) {
    conditions_.push_back({at_, false, false, false, true});
    return;
  }
  // Asked before it is pushed: the handler may parse on in another session, but its answer belongs here.
  const Branch branch = handler().ifBegin(test, params, at_);
  conditions_.push_back({at_});
  setBranch(branch);
}

void ParseSession::elseIf(std::string_view test, const ParamList& params, bool valid) {
  if (!insideIf()) return;
  Condition& condition = conditions_.back();
  if (condition.dead) return;
  if (condition.all) {
    condition.deliver = valid;
    if (valid) handler().elseIf(test, params, at_);
  } else if (condition.taken) {
    condition.deliver = false;
  } else {
    setBranch(valid ? handler().elseIf(test, params, at_) : Branch::Skip);
  }
}

void ParseSession::otherwise() {
  if (!insideIf()) return;
  Condition& condition = conditions_.back();
  if (condition.dead) return;
  if (condition.all) {
    condition.deliver = true;
    handler().else_(at_);
  } else if (condition.taken) {
    condition.deliver = false;
  } else {
    setBranch(handler().else_(at_));
  }
}

void ParseSession::ifEnd() {
  if (!insideIf()) return;
  const bool dead = conditions_.back().dead;
  conditions_.pop_back();
  if (!dead) handler().ifEnd(at_);
}

bool ParseSession::insideIf() {
  if (conditions_.empty()) error(RiError::Nesting, nameBegin_, "no IfBegin is open");
  return !conditions_.empty();
}

}  // namespace patina
