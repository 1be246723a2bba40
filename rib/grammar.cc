// SPDX-License-Identifier: Apache-2.0
// The grammar of RIB in Boost.Spirit X3, over terminals that know both encodings. The only file that sees X3.
#include <boost/spirit/home/x3.hpp>

#include "rib/first_bytes.h"
#include "rib/session.h"

namespace patina {
namespace {

namespace x3 = boost::spirit::x3;

struct SessionTag;

template <typename Context>
ParseSession& session(const Context& context) {
  return x3::get<SessionTag>(context).get();
}

// A token, or a run of tokens, that a method of ParseSession recognises and stores.
template <auto Method, first_byte::Set First>
struct Terminal : x3::parser<Terminal<Method, First>> {
  using attribute_type = x3::unused_type;
  static constexpr bool has_attribute = false;

  template <typename Context, typename RuleContext, typename Attribute>
  bool parse(const char*& first, const char* const& last, const Context& context, RuleContext&,
             Attribute&) const {
    if (first == last || !first_byte::mayBegin(First, *first)) return First == first_byte::Blank;
    const char* const next = (session(context).*Method)(first, last);
    if (!next) return false;
    first = next;
    return true;
  }
};

constexpr Terminal<&ParseSession::blank, first_byte::Blank> blank;
constexpr Terminal<&ParseSession::word, first_byte::Word> word;
constexpr Terminal<&ParseSession::numbers, first_byte::Number> numbers;
constexpr Terminal<&ParseSession::string, first_byte::String> string;
constexpr Terminal<&ParseSession::floatArray, first_byte::FloatArray> floatArray;
constexpr Terminal<&ParseSession::strayWord, first_byte::Letter> strayWord;
constexpr Terminal<&ParseSession::strayByte, first_byte::Stray> strayByte;
constexpr Terminal<&ParseSession::strayByte, first_byte::StrayInArray> strayInArray;

// Where an action stands: behind what its parser has matched.
template <typename Context>
const char* here(const Context& context) {
  return x3::_where(context).begin();
}

constexpr auto beginRequest = [](auto& ctx) { session(ctx).beginRequest(); };
constexpr auto endRequest = [](auto& ctx) { x3::_pass(ctx) = session(ctx).endRequest(); };
constexpr auto beginArray = [](auto& ctx) { session(ctx).beginArray(here(ctx)); };
constexpr auto endArray = [](auto& ctx) { session(ctx).endArray(here(ctx), true); };
constexpr auto unclosedArray = [](auto& ctx) { session(ctx).endArray(here(ctx), false); };
constexpr auto beginStray = [](auto& ctx) { x3::_pass(ctx) = session(ctx).beginStray(here(ctx)); };

// Each token takes the blanks behind it, so that none is read twice.
const auto nested = x3::char_('[')[beginArray];
const auto element = numbers | string | floatArray | nested | strayWord | strayInArray;
const auto array = x3::char_('[')[beginArray] >> blank >> *(element >> blank) >>
                   (x3::char_(']')[endArray] | x3::eps[unclosedArray]);
const auto value = numbers | string | array | floatArray | strayByte;
const auto request = word[beginRequest] >> blank >> *(value >> blank) >> x3::eps[endRequest];
const auto stray = x3::eps[beginStray] >> +(value >> blank);
const auto file = blank >> *(request | stray);

}  // namespace

void parseRib(const char* first, const char* last, ParseSession& session) {
  x3::parse(first, last, x3::with<SessionTag>(std::ref(session))[file]);
}

}  // namespace patina
