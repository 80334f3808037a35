#include "balance/foundation/base/spelling.hpp"

#include <doctest/doctest.h>

namespace balance {
namespace {

TEST_CASE("a slip of a name suggests it") {
  const std::vector<std::string> names = {"arm", "crank1", "shaking_force", "A1", "l", "cycloid"};
  CHECK(find_nearest_name("amr", names) == "arm");
  CHECK(find_nearest_name("carnk1", names) == "crank1");
  CHECK(find_nearest_name("CRANK1", names) == "crank1");
  CHECK(find_nearest_name("shakingforce", names) == "shaking_force");
  CHECK(find_nearest_name("A2", names) == "A1");
  CHECK(find_nearest_name("L", names) == "l");
  CHECK(find_nearest_name("cycle", names) == "cycloid");
}

TEST_CASE("another word suggests nothing") {
  const std::vector<std::string> names = {"arm", "crank1", "shaking_force", "A1", "l", "cycloid"};
  for (const char* word : {"foo", "x", "rpy", "platform", "bang-bang", "B9", "", "torque"})
    CHECK_MESSAGE(find_nearest_name(word, names).empty(), word);
  CHECK(append_nearest_name("foo", {"arm"}).empty());
  CHECK(find_nearest_name("foo", {}).empty());
}

TEST_CASE("a short word has one slip, whatever dashes stand before it") {
  CHECK(find_nearest_name("--foo", {"--force", "--help"}).empty());
  CHECK(find_nearest_name("--forec", {"--force", "--help"}) == "--force");
  CHECK(find_nearest_name("spead", {"speed"}) == "speed");
  CHECK(find_nearest_name("spade", {"speed"}).empty());
}

TEST_CASE("a plural is found by its singular, and the other way round") {
  CHECK(find_nearest_name("body", {"name", "bodies", "joints"}) == "bodies");
  CHECK(find_nearest_name("bodies", {"body", "bones"}) == "body");
}

TEST_CASE("the beginning of a name suggests it") {
  CHECK(find_nearest_name("sha", {"arm", "shaking_force"}) == "shaking_force");
  CHECK(find_nearest_name("degrees", {"rad", "deg"}) == "deg");
  CHECK(find_nearest_name("sh", {"arm", "shaking_force"}).empty());
}

TEST_CASE("a decimal comma is reported from commas between numbers") {
  CHECK(format_decimal_point_hint("0,4") == "; use a decimal point: 0.4");
  CHECK(format_decimal_point_hint("-12,50 * l") == "; use a decimal point: 12.50");
  CHECK(format_decimal_point_hint("1.234,5") == "; use a decimal point: 1234.5");
  CHECK(format_decimal_point_hint("1,000.5") == "; use a decimal point: 1000.5");
  CHECK(format_decimal_point_hint("12,345,678") == "; use a decimal point: 12345678");
  CHECK(format_decimal_point_hint("1.5,2.5") == "; use a decimal point and no thousands separators");
  CHECK(format_decimal_point_hint("A1=0,3,A2=0.5") == "; use a decimal point: 0.3");
  for (const char* text : {"0.4", "max(1,2)", "A1,2", "a,1", "1, 2", ",5", "1,", "1,x", ""})
    CHECK_MESSAGE(format_decimal_point_hint(text).empty(), text);
}

}  // namespace
}  // namespace balance
