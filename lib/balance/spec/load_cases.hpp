#pragma once
/// `design: {for: …, across: …, adapt: …}`.

#include "balance/spec/draft.hpp"

namespace balance::read {

/// The names under `design: for`, which read_number looks for. Whatever is wrong with them is told later.
/// @param design null if the spec has none
std::set<std::string> list_load_names(const Cursor* design);

/// A number of the mechanism that `for` may name becomes an input of the recording if it does.
/// @param number its own value [SI]; @param unit that its values in the cases are told in
Expression as_load_number(const Cursor& at, Draft& draft, const Expression& number, double unit, Sign sign);

/// What a free number at a path is to `for`: nothing that it may name.
void note_free(const std::string& path, Draft& draft);

/// @param at the mapping or the list under `for`
void read_load_cases(const Cursor& at, Draft& draft, LoadCases& cases);
AcrossCases read_across(const Cursor& at);
/// Names of free numbers, or of what holds some. @return their paths
std::set<std::string> read_adapted(const Cursor& at, const Draft& draft);

}  // namespace balance::read
