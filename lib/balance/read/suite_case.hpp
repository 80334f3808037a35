#pragma once
/// One case of a suite, and what a matrix makes of several values. Private to read.

#include "balance/read/suite.hpp"
#include "balance/spec/cursor.hpp"

#include <set>
#include <string>
#include <vector>

namespace balance::read {

/// A suite while it is read.
struct SuiteDraft {
  explicit SuiteDraft(const std::string& file_name) : file(file_name), problems(file_name) {}

  std::string file;
  Problems problems;
  SuiteCase defaults;
  std::vector<SuiteCase> cases;
  std::set<std::string> names;            ///< of the cases
  std::vector<std::string> spoilt_names;  ///< of cases with mistakes
  bool lacks_names = false;               ///< there are cases with mistakes whose names are not known
  std::vector<std::pair<std::size_t, Cursor>>
      requirements;  ///< of cases, by their index; read when all names are known

  /// "suite.yaml:4:7: cases.a.spec"
  SpecPlace place(const Cursor& at) const;
};

/// What `cases` and `defaults` share: spec, set, trajectory, controller, samples, design.
std::vector<Field> case_fields(SuiteDraft& draft, SuiteCase& one);

/// Where a part of the case is said, from now on.
void note_place(SuiteCase& one, const std::string& part, const SpecPlace& place);

/// A number of samples.
long read_samples(const Cursor& at);

/// A parameter's value: a number or an expression.
std::string read_value(const Cursor& at);

/// Whether a name of a case may begin so: neither hidden, nor like an option, nor like a formula.
bool begins_name(char c);

/// Adds a case. Fails at `named` if its name is taken or cannot be a file's.
void add_case(SuiteDraft& draft, SuiteCase one, const Cursor& named);

/// `matrix`: one mapping of lists, or a list of such.
void read_matrices(const Cursor& section, SuiteDraft& draft);

}  // namespace balance::read
