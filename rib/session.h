// SPDX-License-Identifier: Apache-2.0
// One parse call at work: the tokens that the grammar is made of, the request under way, and what is skipped.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "rib/parser.h"
#include "rib/pool.h"
#include "rib/requests.h"
#include "rib/source.h"

namespace patina {

// What binary RIB defines as it goes (codes 0314 to 0316).
struct EncodingTables {
  std::array<std::string, 256> requests;
  std::map<uint32_t, std::shared_ptr<const std::string>> strings;
};

// The grammar calls the terminals and the actions; a terminal returns the position behind its token, or null
// when no such token is at `p` (then nothing has changed). Terminals are called with p < end.
class ParseSession : private SourceText {
 public:
  ParseSession(RibParser& parser, ValuePool& pool, std::string_view text, const Location& start,
               std::shared_ptr<EncodingTables> tables);

  // Reads the whole text. False: stopped by ErrorHandler::aborted() or by lack of memory.
  bool run();

  // Terminals
  const char* blank(const char* p, const char* end);    // blanks, comments, definitions; may be empty
  const char* word(const char* p, const char* end);     // a request's name
  const char* numbers(const char* p, const char* end);  // a run of numbers
  const char* string(const char* p, const char* end);
  const char* floatArray(const char* p, const char* end);  // the binary token
  const char* strayWord(const char* p, const char* end);   // in an array: a word that names no request
  const char* strayByte(const char* p, const char* end);  // what can begin no token: up to the next delimiter

  // Actions
  void beginRequest();                        // of the word just read
  bool endRequest();                          // carries it out; false: stop reading
  void beginArray(const char* p);             // behind the bracket
  void endArray(const char* p, bool closed);  // behind the bracket, if there is one
  bool beginStray(const char* p);  // values where a request should be; false: not so, or stop reading

  // For the request's arguments
  RibHandler& handler() { return parser_.handler_; }
  ErrorHandler& errors() { return parser_.errors_; }
  Dictionary& dictionary() { return parser_.dictionary_; }
  bool firstTime(std::string_view name) { return parser_.firstTime(name); }
  ValuePool& pool() { return pool_; }
  const Location& at() const { return at_; }
  std::string_view requestName() const { return name_; }
  const RibRequest* request() const { return request_; }
  const char* nameBegin() const { return nameBegin_; }
  bool failed() const { return failed_; }
  Location locate(const char* p) { return lines_.locate(p); }

  // Reports the request's first error; later ones are dropped.
  void error(RiError code, const char* p, std::string_view message, std::string_view key = {});

  // The control requests, which change what is delivered
  // `valid` is false when the arguments were refused: such a branch is skipped.
  void ifBegin(std::string_view test, const ParamList& params, bool valid);
  void elseIf(std::string_view test, const ParamList& params, bool valid);
  void otherwise();
  void ifEnd();
  void archiveBegin(std::string_view name, const ParamList& params);

 private:
  // An IfBegin that is open.
  struct Condition {
    Location at;
    bool deliver = false;  // the branch under way is delivered
    bool taken = false;    // some branch was, so that no other is asked
    bool all = false;      // every branch is delivered
    bool dead = false;     // the whole IfBegin is skipped: inside something skipped, or refused itself
  };

  std::optional<std::string_view> line(const Location& at) const override;
  bool delivering() const { return conditions_.empty() || conditions_.back().deliver; }
  bool quiet() const { return recordDepth_ > 0 || !delivering(); }
  void fatal(RiError code, const char* p, std::string_view message, std::string_view key = {});
  void spoilArray();
  void reportUnknown();
  bool insideIf();
  const char* truncated(const char* p, std::string_view what, const char* end);  // returns end
  void addNumbers(size_t first, const char* begin, const char* end, bool bad);
  void addString(std::string_view text, const char* begin, const char* end);
  const char* comment(const char* p, const char* end);
  const char* definition(const char* p, const char* end);
  const char* quotedString(const char* p, const char* end, std::string_view& text);
  const char* binaryString(const char* p, const char* end, std::string_view& text);
  const char* oddNumber(const char* p, const char* end, bool& bad);
  const char* binaryNumber(const char* p, const char* end, double& value);
  void record();
  void carryOut();
  void deliverComments();
  void setBranch(Branch branch);

  RibParser& parser_;
  ValuePool& pool_;
  std::string_view text_;
  Location start_;
  LineMap lines_;
  std::shared_ptr<EncodingTables> tables_;  // shared with archives recorded here; copied before it changes
  std::vector<std::shared_ptr<const std::string>> retired_;  // redefined strings that this request may view

  const RibRequest* request_ = nullptr;  // null: unknown
  std::string_view name_;
  const char* nameBegin_ = nullptr;
  Location at_;
  bool inRequest_ = false;
  bool inArray_ = false;
  bool reported_ = false;      // an error of this request was reported
  bool failed_ = false;        // the request must not be carried out
  bool afterUnknown_ = false;  // the last request was unknown and had no values
  bool stopped_ = false;

  std::vector<Condition> conditions_;
  int recordDepth_ = 0;  // ArchiveBegins open since recording began
  const char* recordBegin_ = nullptr;
  Location recordTextAt_, recordAt_;
  std::string recordName_;
  std::shared_ptr<EncodingTables> recordTables_;
};

// The X3 grammar over a session (grammar.cc). Consumes all of the text unless the session stops it.
void parseRib(const char* first, const char* last, ParseSession& session);

}  // namespace patina
