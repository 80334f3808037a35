#include "balance/foundation/base/unicode_text.hpp"

#include <doctest/doctest.h>

#include <string>

using namespace balance;

TEST_CASE("a name is a letter of any script, then letters, digits, '_' and '-' (C8)") {
  for (const char* name : {"a", "J1", "cw_2", "long-link", "Kurbel\xC3\xA9", "\xE6\x9B\xB2\xE6\x9F\x84",
                           "\xD1\x82\xD1\x8F\xD0\xB3\xD0\xB0", "\xCE\xB8", "e\xCC\x81", "\xF0\xA0\x80\x80"}) {
    CAPTURE(name);
    CHECK(is_unicode_identifier(name));
  }
  for (const char* name : {"",
                           "1a",
                           "_a",
                           "-a",
                           "a b",
                           "a.b",
                           "a=b",
                           "=1+1",
                           "a\x1b[31m",
                           "a\x07",
                           "a\x7f",
                           "a\xC2\x9B",
                           "a\xE2\x80\xAE",
                           "a\xE2\x80\x8B",
                           "a\xC2\xA0",
                           "a\xE3\x80\x80",
                           "\xEF\xBB\xBF"
                           "a",
                           "a\xED\xA0\x80",
                           "a\xC0\x80",
                           "a\xFF",
                           "a\xEF\xBF\xBF",
                           "a\xEE\x80\x80",
                           "a\xE2\x86\x92",
                           "a\xC2\xBD",
                           "a\xF0\x9F\x98\x80",
                           "\xCC\x81"
                           "a",
                           "a$",
                           "a&",
                           "a%",
                           "a\\",
                           "a\"",
                           "a|b",
                           "a`",
                           "a\xF3\xA0\x80\x81",
                           "a\xF4\x90\x80\x80"}) {
    CAPTURE(name);
    CHECK_FALSE(is_unicode_identifier(name));
  }
  CHECK_FALSE(is_unicode_identifier(std::string("a\0b", 3)));
}

TEST_CASE("what cannot be seen or steers a terminal is spelt out (C8)") {
  CHECK(escape_for_terminal("plain \xC3\xA9 \xE6\x9B\xB2") == "plain \xC3\xA9 \xE6\x9B\xB2");
  CHECK(escape_for_terminal("\x1b[31m\x07") == "\\x1b[31m\\x07");
  CHECK(escape_for_terminal(std::string("a\0b", 3)) == "a\\x00b");
  CHECK(escape_for_terminal("a\nb\tc") == "a\\x0ab\\x09c");
  CHECK(escape_lines_for_terminal("a\nb\tc\r") == "a\nb\tc\\x0d");
  CHECK(escape_for_terminal("\xC2\x9B"
                            "31m") == "<U+009B>31m");
  CHECK(escape_for_terminal("a\xE2\x80\xAE"
                            "b\xE2\x81\xA6") == "a<U+202E>b<U+2066>");
  CHECK(escape_lines_for_terminal("\xE2\x80\xA8") == "<U+2028>");
  CHECK(escape_for_terminal("\xED\xA0\x80") == "\\xed\\xa0\\x80");
  CHECK(escape_for_terminal("\xC3") == "\\xc3");
  CHECK(escape_for_terminal("\xF3\xA0\x81\x81") == "<U+E0041>");
}

TEST_CASE("UTF-8 has no surrogates, no overlong forms and an end (C8)") {
  CHECK(is_utf8("a\xC3\xA9\xF0\x9F\x98\x80"));
  for (const char* text : {"\xED\xA0\x80", "\xED\xBF\xBF", "\xC0\xAF", "\xE0\x80\xAF", "\xF0\x80\x80\xAF",
                           "\xF4\x90\x80\x80", "\x80", "\xE2\x82", "\xF8\x88\x80\x80\x80"})
    CHECK_FALSE(is_utf8(text));
}
