#include "balance/interface/files/report_fields.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

using namespace balance;
using namespace balance::files;

namespace {

struct Thing {
  std::string name, unit;
  double size, time;
};

const ReportFields<Thing>& thing_fields() {
  static const ReportFields<Thing> all{
      {&Thing::name, JsonKey{"name"}, TextColumn{"thing"}, Hdf5Dataset{"what it is"}},
      {&Thing::unit, TextColumn{"unit"}, unit_name_or_1},
      {&Thing::size, JsonKey{"extent/size"}, TextColumn{"size"}},
      {[](const Thing& row) { return row.size > 1 ? Json(true) : Json(); }, JsonKey{"extent/large"}},
      {&Thing::time, JsonKey{"time"}, TextColumn{std::nullopt, "{:.2f}"}, SiUnit{"s"}},
      {[](const Thing& row) { return row.time > 0 ? "later" : ""; }, TextColumn{"when"}}};
  return all;
}

const std::vector<Thing> things{{"rod", "m", 2, 0.5}, {"ratio", "1", 0, 0}};

}  // namespace

TEST_CASE("a field is in the formats that it names, under its key unless it has another name there") {
  CHECK(rows_json(things, thing_fields()).dump() ==
        R"([{"name":"rod","extent":{"size":2.0,"large":true},"time":0.5},)"
        R"({"name":"ratio","extent":{"size":0.0,"large":null},"time":0.0}])");
  CHECK(rows_table(things, thing_fields()).heading ==
        std::vector<std::string>{"thing", "unit", "size", "time [s]", "when"});
  CHECK(thing_fields().front().dataset->name == "name");
  CHECK_FALSE(thing_fields().back().dataset);
}

TEST_CASE("a table has numbers in the unit of their row or of their field, aligned right") {
  specification::SpecUnits units;
  units.length = 1e-3, units.length_name = "mm";
  units.time = 60, units.time_name = "min";
  const TextTable table = rows_table(things, thing_fields(), units);
  CHECK(table.rows.front() == std::vector<std::string>{"rod", "mm", "2000.00", "0.01", "later"});
  CHECK(table.rows.back() == std::vector<std::string>{"ratio", "1", "0", "0.00", ""});
  CHECK(table.heading[3] == "time [min]");
  using enum Align;
  CHECK(table.align == std::vector<Align>{left, left, right, right, left});
}

TEST_CASE("a figure is a number of six digits, an exact zero or unknown") {
  CHECK(format_figure(0.5) == "0.500000");
  CHECK(format_figure(-0.0) == "0");
  CHECK(format_figure(std::numeric_limits<double>::quiet_NaN()) == "-");
}
