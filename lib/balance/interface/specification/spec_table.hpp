#pragma once
/// Values over time, from the spec or from a CSV or HDF5 file beside it.

#include "balance/interface/specification/study_builder.hpp"

#include <stdexcept>
#include <string>
#include <vector>

namespace balance::specification {

/// A column that a table may have.
struct TableColumn {
  std::string name;
  Dimension dimension;
};

/// What the values of most tables depend on.
inline const TableColumn time_column{"time", dimension::time};

/// `[[t, …], …]`, each row an argument and one number per column. Fails unless the arguments increase.
TimeTable read_inline_table(const SpecCursor& at, StudyBuilder& draft, const std::vector<TableColumn>& columns,
                            const TableColumn& argument = time_column);
/// A file beside the spec with a column of the argument and some of the possible columns, in any order, in the spec's
/// units.
TimeTable read_table_file(const SpecCursor& at, StudyBuilder& draft, const std::vector<TableColumn>& possible,
                          const TableColumn& argument = time_column);

/// Path of a file that is given relative to the spec's folder. Fails unless there is such a file, of bearable size.
std::string find_table_file(const SpecCursor& at, const StudyBuilder& draft);

/// Throws a ReadError at `at` unless the arguments increase.
void check_increasing(const SpecCursor& at, const std::vector<Expression>& values, const TableColumn& argument);

/// Content of a file, in the file's units.
struct RawTable {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
};

/// A malformed table file; the message says where.
struct TableError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Content of a file that is given relative to the spec's folder. Fails if there is none, or if it is too large.
std::string read_file_beside_spec(const SpecCursor& at, const StudyBuilder& draft);

/// CSV: a line of column names, then numbers, separated by commas; `#` starts a comment. @throws TableError
RawTable parse_csv(const std::string& text);
/// Those of the named one-dimensional datasets of the root group that exist. @throws TableError
RawTable read_hdf5_table(const std::string& path, const std::vector<std::string>& names);

}  // namespace balance::specification
