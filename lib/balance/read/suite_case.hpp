#pragma once
/// One case of a suite, and what a matrix makes of several values. Private to read.

#include "balance/read/suite.hpp"
#include "balance/spec/cursor.hpp"

#include <set>
#include <string>
#include <vector>

namespace balance::specification {

/// A suite while it is read.
struct SuiteBuilder {
  explicit SuiteBuilder(const std::string& file_name) : file(file_name), problems(file_name) {}

  std::string file;
  SpecErrorCollector problems;
  SuiteCase defaults;
  std::vector<SuiteCase> cases;
  std::set<std::string> names;                  ///< of the cases
  std::vector<std::string> invalid_case_names;  ///< of cases with mistakes
  bool has_unnamed_cases = false;               ///< there are cases with mistakes whose names are not known
  std::vector<std::pair<std::size_t, SpecCursor>>
      requirements;  ///< of cases, by their index; read when all names are known

  /// "suite.yaml:4:7: cases.a.spec"
  SourceLocation place(const SpecCursor& at) const;
};

/// What `cases` and `defaults` share: spec, set, trajectory, controller, samples, design.
std::vector<Field> make_case_fields(SuiteBuilder& draft, SuiteCase& one);

/// Where a part of the case is said, from now on.
void record_location(SuiteCase& one, const std::string& part, const SourceLocation& place);

/// A number of samples.
long read_samples(const SpecCursor& at);

/// A parameter's value: a number or an expression.
std::string read_value(const SpecCursor& at);

/// Whether a name of a case may begin so: neither hidden, nor like an option, nor like a formula.
bool is_case_name_start(char c);

/// Adds a case. Fails at `named` if its name is taken or cannot be a file's.
void add_case(SuiteBuilder& draft, SuiteCase one, const SpecCursor& named);

/// `matrix`: one mapping of lists, or a list of such.
void read_matrices(const SpecCursor& section, SuiteBuilder& draft);

}  // namespace balance::specification
