#include "balance/base/nearest.hpp"

#include <doctest/doctest.h>

namespace balance {
namespace {

TEST_CASE("a slip of a name suggests it") {
  const std::vector<std::string> names = {"arm", "crank1", "shaking_force", "A1", "l", "cycloid"};
  CHECK(nearest("amr", names) == "arm");
  CHECK(nearest("carnk1", names) == "crank1");
  CHECK(nearest("CRANK1", names) == "crank1");
  CHECK(nearest("shakingforce", names) == "shaking_force");
  CHECK(nearest("A2", names) == "A1");
  CHECK(nearest("L", names) == "l");
  CHECK(nearest("cycle", names) == "cycloid");
}

TEST_CASE("another word suggests nothing") {
  const std::vector<std::string> names = {"arm", "crank1", "shaking_force", "A1", "l", "cycloid"};
  for (const char* word : {"foo", "x", "rpy", "platform", "bang-bang", "B9", "", "torque"})
    CHECK_MESSAGE(nearest(word, names).empty(), word);
  CHECK(nearest_hint("foo", {"arm"}).empty());
  CHECK(nearest("foo", {}).empty());
}

TEST_CASE("a short word has one slip, whatever dashes stand before it") {
  CHECK(nearest("--foo", {"--force", "--help"}).empty());
  CHECK(nearest("--forec", {"--force", "--help"}) == "--force");
  CHECK(nearest("spead", {"speed"}) == "speed");
  CHECK(nearest("spade", {"speed"}).empty());
}

TEST_CASE("a plural is found by its singular, and the other way round") {
  CHECK(nearest("body", {"name", "bodies", "joints"}) == "bodies");
  CHECK(nearest("bodies", {"body", "bones"}) == "body");
}

TEST_CASE("the beginning of a name suggests it") {
  CHECK(nearest("sha", {"arm", "shaking_force"}) == "shaking_force");
  CHECK(nearest("degrees", {"rad", "deg"}) == "deg");
  CHECK(nearest("sh", {"arm", "shaking_force"}).empty());
}

TEST_CASE("a decimal comma is told from commas between numbers") {
  CHECK(decimal_comma_hint("0,4") == "; decimals stand behind a point: 0.4");
  CHECK(decimal_comma_hint("-12,50 * l") == "; decimals stand behind a point: 12.50");
  CHECK(decimal_comma_hint("1.234,5") == "; decimals stand behind a point: 1234.5");
  CHECK(decimal_comma_hint("1,000.5") == "; decimals stand behind a point: 1000.5");
  CHECK(decimal_comma_hint("12,345,678") == "; decimals stand behind a point: 12345678");
  CHECK(decimal_comma_hint("1.5,2.5") == "; decimals stand behind a point, and nothing between thousands");
  CHECK(decimal_comma_hint("A1=0,3,A2=0.5") == "; decimals stand behind a point: 0.3");
  for (const char* text : {"0.4", "max(1,2)", "A1,2", "a,1", "1, 2", ",5", "1,", "1,x", ""})
    CHECK_MESSAGE(decimal_comma_hint(text).empty(), text);
}

}  // namespace
}  // namespace balance
