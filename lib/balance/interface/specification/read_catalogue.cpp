#include "balance/interface/specification/read_catalogue.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/foundation/base/unicode_text.hpp"
#include "balance/interface/specification/spec_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

namespace balance::specification {

namespace {

constexpr std::size_t max_catalogue_rows = 100'000, max_catalogue_columns = 1000, max_part_name_length = 200;
constexpr long max_part_count = 1000;

}  // namespace

std::vector<TextRow> parse_text_table(const std::string& text) {
  std::vector<TextRow> rows;
  std::size_t i = std::string_view(text).starts_with("\xEF\xBB\xBF") ? 3 : 0;
  long line = 1;
  const auto fail = [&](const std::string& what) { throw TableError(fmt::format("line {}: {}", line, what)); };
  if (!is_utf8(text) || text.find('\0') != std::string::npos)
    throw TableError("expected text in UTF-8, found other bytes: save the table as \"CSV UTF-8\"");
  while (i < text.size()) {
    TextRow row{line, {}};
    const std::size_t begin = i;
    bool ends = false;
    while (!ends) {
      std::string field;
      while (i < text.size() && (text[i] == ' ' || text[i] == '\t')) ++i;
      if (i < text.size() && text[i] == '"') {
        for (++i;; ++i) {
          if (i >= text.size()) fail("a quote has no end");
          if (text[i] == '"' && i + 1 < text.size() && text[i + 1] == '"')
            ++i;
          else if (text[i] == '"')
            break;
          if (text[i] == '\n') ++line;
          field += text[i];
        }
        for (++i; i < text.size() && text[i] != ',' && text[i] != '\n'; ++i)
          if (text[i] != ' ' && text[i] != '\t' && text[i] != '\r') fail("expected a comma behind a quoted field");
      } else {
        const std::size_t end = std::min(text.find_first_of(",\n", i), text.size());
        field = trim(std::string_view(text).substr(i, end - i));
        i = end;
      }
      if (row.fields.size() == max_catalogue_columns) fail(fmt::format("more than {} columns", max_catalogue_columns));
      row.fields.push_back(std::move(field));
      ends = i >= text.size() || text[i] == '\n';
      ++i;
    }
    ++line;
    const bool is_blank = row.fields.size() == 1 && row.fields[0].empty();
    if (is_blank || text[begin] == '#') continue;
    if (!rows.empty() && row.fields.size() != rows[0].fields.size())
      throw TableError(fmt::format("line {}: expected {} fields as in the header line, found {}", row.line,
                                   rows[0].fields.size(), row.fields.size()));
    if (rows.size() > max_catalogue_rows) fail(fmt::format("more than {} rows", max_catalogue_rows));
    rows.push_back(std::move(row));
  }
  if (rows.empty()) throw TableError("expected a header line of column names, found an empty file");
  if (rows.size() == 1) throw TableError("expected at least one row below the header line, found none");
  return rows;
}

namespace {

/// A column's name and the unit behind it, as in "rate [N/mm]".
struct Heading {
  std::string name, unit;
};

Heading split_heading(const std::string& text) {
  const std::size_t open = text.find_last_of("[(");
  if (open == std::string::npos || text.empty() || (text.back() != ']' && text.back() != ')')) return {text, ""};
  return {std::string(trim(std::string_view(text).substr(0, open))),
          std::string(trim(std::string_view(text).substr(open + 1, text.size() - open - 2)))};
}

/// What a property is called in the file, and its unit if the spec states one.
struct ColumnRequest {
  std::string column, unit;
  std::optional<SpecCursor> place;  ///< none: not stated, named after the property
};

constexpr const char* part_property = "part";
constexpr const char* mass_property = "mass";
constexpr const char* price_property = "price";

/// Reads one file for one element.
class CatalogueReader {
 public:
  CatalogueReader(const std::string& path, const CatalogueKeys& keys, StudyBuilder& draft,
                  const std::vector<CatalogueProperty>& properties)
      : keys_(keys), draft_(draft), properties_(properties) {
    choice_.path = path;
  }

  study::CatalogueChoice read() {
    read_file_entry();
    read_column_entry();
    read_count_entry();
    read_chosen_count();
    const auto file = std::make_shared<study::CatalogueFile>();
    file->name = file_entry_->read_word("a file's name");
    file->text = read_file_beside_spec(*file_entry_, draft_);
    choice_.file = file;
    try {
      read_rows(parse_text_table(file->text));
    } catch (const TableError& error) {
      file_entry_->fail({.message = escape_for_terminal(file->name) + ": " + error.what(),
                         .expected = "a catalogue of parts",
                         .found = quote_for_message(file->name),
                         .hint = error.what()});
    }
    choose_row();
    return std::move(choice_);
  }

 private:
  void read_file_entry() {
    const SpecCursor& at = *keys_.catalogue;
    if (!at.is_map()) {
      file_entry_ = at;
      return;
    }
    const bool is_valid =
        read_fields(at, "a catalogue {file, part, count, start}",
                    {{"file", Presence::required, [&](const SpecCursor& c) { file_entry_ = c; }},
                     {"part", Presence::optional, [&](const SpecCursor& c) { part_entry_ = c; }},
                     {"count", Presence::optional, [&](const SpecCursor& c) { chosen_count_entry_ = c; }},
                     {"start", Presence::optional, [&](const SpecCursor& c) { start_entry_ = c; }}});
    if (!is_valid) throw CascadingError();
    if (chosen_count_entry_ && !part_entry_)
      chosen_count_entry_->fail(
          {.expected = "'part' with 'count'; how many may be chosen is 'count' beside 'catalogue'", .found = "none"});
    if (part_entry_ && start_entry_) start_entry_->fail({.expected = "no 'start' with 'part'", .found = "both"});
  }

  std::vector<std::string> property_names() const {
    std::vector<std::string> names{part_property};
    for (const CatalogueProperty& property : properties_) names.push_back(property.name);
    for (const char* name : {mass_property, price_property})
      if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
    return names;
  }

  void read_column_entry() {
    if (!keys_.columns) return;
    std::vector<Field> fields;
    for (const std::string& name : property_names())
      fields.push_back({name, Presence::optional, [this, name](const SpecCursor& c) {
                          ColumnRequest request{"", "", c};
                          const auto read_name = [&](const SpecCursor& n) {
                            request.column = n.read_word("a column's name");
                          };
                          if (!c.is_map())
                            read_name(c);
                          else if (!read_fields(c, "a column {column, unit}",
                                                {{"column", Presence::required, read_name},
                                                 {"unit", Presence::optional, [&](const SpecCursor& u) {
                                                    if (name != price_property) read_unit_product(u);
                                                    request.unit = u.read_word("a unit");
                                                  }}}))
                            throw CascadingError();
                          requests_[name] = std::move(request);
                        }});
    if (!read_fields(*keys_.columns, "columns of the catalogue, by the key that they stand for", fields))
      throw CascadingError();
    if (keys_.columns->node().items.empty()) keys_.columns->fail_expected("at least one column");
  }

  void read_count_entry() {
    counts_ = {1};
    if (!keys_.count) return;
    counts_.clear();
    const auto read_one = [&](const SpecCursor& c) {
      const auto count = static_cast<int>(read_integer(c, draft_, 1, max_part_count));
      if (std::find(counts_.begin(), counts_.end(), count) != counts_.end())
        c.fail({.expected = "each number only once", .found = fmt::format("{} again", count)});
      counts_.push_back(count);
    };
    if (!keys_.count->is_list())
      read_one(*keys_.count);
    else
      read_each(keys_.count->items("a number of parts, or a list of such numbers"), read_one);
    if (counts_.empty()) keys_.count->fail_expected("at least one number");
  }

  /// How many of a given part there are.
  void read_chosen_count() {
    if (!chosen_count_entry_) return;
    const auto count = static_cast<int>(read_integer(*chosen_count_entry_, draft_, 1, max_part_count));
    if (keys_.count && std::find(counts_.begin(), counts_.end(), count) == counts_.end())
      chosen_count_entry_->fail({.expected = "one of the numbers under 'count'", .found = fmt::format("{}", count)});
    counts_ = {count};
  }

  /// Index of a property's column in the file; −1 if there is none.
  int find_column(const std::string& property, const std::vector<Heading>& headings) const {
    const auto request = requests_.find(property);
    const std::string& name = request == requests_.end() ? property : request->second.column;
    int found = -1;
    for (std::size_t i = 0; i < headings.size(); ++i) {
      if (headings[i].name != name && full_names_[i] != name) continue;
      if (found >= 0)
        throw TableError(fmt::format("expected each column only once, found {} again", quote_for_message(name)));
      found = static_cast<int>(i);
    }
    if (found < 0 && request != requests_.end()) {
      std::vector<std::string> names;
      for (const Heading& heading : headings) names.push_back(heading.name);
      request->second.place->fail(
          {.expected =
               fmt::format("a column of {} ({})", escape_for_terminal(choice_.file->name), join_alternatives(names)),
           .found = quote_for_message(name),
           .hint = name.size() < 60 && headings.size() == 1 && headings[0].name.find(';') != std::string::npos
                       ? "use commas between columns and points before decimals"
                       : format_nearest_name(name, names)});
    }
    return found;
  }

  /// SI value of a column's unit. @throws TableError if it does not fit
  double unit_of(const CatalogueProperty& property, const Heading& heading) const {
    const auto request = requests_.find(property.name);
    const std::string text =
        request != requests_.end() && !request->second.unit.empty() ? request->second.unit : heading.unit;
    if (text.empty()) return draft_.units.factor(property.dimension);
    const std::optional<UnitProduct> unit = parse_unit_product(text);
    if (text != heading.unit && !heading.unit.empty()) {
      const std::optional<UnitProduct> own = parse_unit_product(heading.unit);
      if (!own || !unit || own->value != unit->value)
        throw TableError(fmt::format("column {}: expected one unit, found {} in the file and {} in 'columns'",
                                     quote_for_message(heading.name), quote_for_message(heading.unit),
                                     quote_for_message(text)));
    }
    Dimension expanded = property.dimension;
    const int force = std::exchange(expanded.force, 0);
    expanded.mass += force, expanded.length += force, expanded.time -= 2 * force;
    Dimension without_angle = unit ? unit->dimension : Dimension{};
    without_angle.angle = expanded.angle;  // N m as N m/rad
    const bool fits =
        unit && (unit->dimension == expanded || (unit->dimension.angle == 0 && without_angle == expanded));
    if (!fits)
      throw TableError(fmt::format("column {}: expected a unit of {} such as {}, found {}",
                                   quote_for_message(heading.name), property.name,
                                   unit_of_dimension(property.dimension), quote_for_message(text)));
    return unit->value;
  }

  double read_value(const TextRow& row, int column, double unit, SignConstraint sign, const Heading& heading) const {
    const std::string& text = row.fields[static_cast<std::size_t>(column)];
    std::string_view digits = text;
    if (digits.size() > 1 && digits[0] == '+') digits.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    value *= unit;
    const auto fail = [&](const char* expected) {
      throw TableError(fmt::format("line {}, column {}: expected {}, found {}", row.line,
                                   quote_for_message(heading.name), expected,
                                   text.empty() ? "nothing" : quote_for_message(text)));
    };
    if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value)) fail("a finite number");
    if (sign == SignConstraint::positive && !(value > 0)) fail("a number > 0");
    if (sign != SignConstraint::none && value < 0) fail("a number ≥ 0");
    return value;
  }

  void read_rows(const std::vector<TextRow>& table) {
    std::vector<Heading> headings;
    for (const std::string& field : table[0].fields) {
      full_names_.push_back(field);
      headings.push_back(split_heading(field));
    }
    const std::size_t rows = table.size() - 1;
    if (rows * counts_.size() > max_catalogue_rows)
      throw TableError(fmt::format("{} rows with {} numbers of parts each are more than {} choices", rows,
                                   counts_.size(), max_catalogue_rows));
    const int name_column = find_column(part_property, headings);
    std::map<std::string, long> lines;
    for (std::size_t r = 1; r < table.size(); ++r) {
      const std::string name =
          name_column < 0 ? fmt::format("row {}", r) : table[r].fields[static_cast<std::size_t>(name_column)];
      if (name.empty()) throw TableError(fmt::format("line {}: the part has no name", table[r].line));
      if (name.size() > max_part_name_length)
        throw TableError(
            fmt::format("line {}: the part's name is longer than {} bytes", table[r].line, max_part_name_length));
      if (const auto [other, is_new] = lines.emplace(name, table[r].line); !is_new)
        throw TableError(fmt::format("line {}: the part {} is also in line {}", table[r].line, quote_for_message(name),
                                     other->second));
      for (const int count : counts_) {
        choice_.parts.push_back(name);
        choice_.counts.push_back(count);
      }
    }
    const auto read_column = [&](const CatalogueProperty& property, double fixed_unit) -> std::vector<double> {
      const int column = find_column(property.name, headings);
      if (column < 0) return {};
      const Heading& heading = headings[static_cast<std::size_t>(column)];
      const double unit = fixed_unit > 0 ? fixed_unit : unit_of(property, heading);
      std::vector<double> values;
      for (std::size_t r = 1; r < table.size(); ++r)
        values.insert(values.end(), counts_.size(), read_value(table[r], column, unit, property.sign, heading));
      return values;
    };
    for (const CatalogueProperty& property : properties_)
      if (std::vector<double> values = read_column(property, 0); !values.empty())
        choice_.columns.push_back({property.name, unit_of_dimension(property.dimension), std::move(values), -1});
    choice_.masses = read_column({mass_property, dimension::mass}, 0);
    choice_.prices = read_column({price_property, dimension::dimensionless}, 1);
    if (const int column = find_column(price_property, headings); column >= 0) {
      const auto request = requests_.find(price_property);
      const Heading& heading = headings[static_cast<std::size_t>(column)];
      choice_.currency = request != requests_.end() && !request->second.unit.empty() ? request->second.unit
                         : !heading.unit.empty()                                     ? heading.unit
                         : heading.name != price_property                            ? heading.name
                                                                                     : "";
    }
    if (choice_.columns.empty()) {
      std::vector<std::string> names;
      for (const CatalogueProperty& property : properties_) names.push_back(property.name);
      throw TableError(fmt::format("expected one of the columns {}, found none; 'columns' says what they are called",
                                   join_alternatives(names)));
    }
  }

  void choose_row() {
    choice_.is_free = !part_entry_ && choice_.rows() > 1;
    const std::optional<SpecCursor>& entry = part_entry_ ? part_entry_ : start_entry_;
    if (!entry) return;
    const std::string& name = entry->read_word("a part's name");
    const auto match = std::find(choice_.parts.begin(), choice_.parts.end(), name);
    if (match == choice_.parts.end()) {
      std::vector<std::string> names = choice_.parts;
      names.erase(std::unique(names.begin(), names.end()), names.end());
      entry->fail({.expected = "a part of " + escape_for_terminal(choice_.file->name),
                   .found = quote_for_message(name),
                   .hint = format_nearest_name(name, names)});
    }
    choice_.row = static_cast<int>(match - choice_.parts.begin());
    if (!part_entry_) return;
    choice_.is_free = counts_.size() > 1;
    keep_only(name);
  }

  /// A given part whose number is still open.
  void keep_only(const std::string& name) {
    const auto first = std::find(choice_.parts.begin(), choice_.parts.end(), name) - choice_.parts.begin();
    const auto cut = [&](auto& values) {
      if (values.empty()) return;
      const auto begin = values.begin() + first;
      values = std::decay_t<decltype(values)>(begin, begin + static_cast<std::ptrdiff_t>(counts_.size()));
    };
    for (study::CatalogueColumn& column : choice_.columns) cut(column.values);
    cut(choice_.masses);
    cut(choice_.prices);
    cut(choice_.parts);
    cut(choice_.counts);
    choice_.row = 0;
  }

  const CatalogueKeys& keys_;
  StudyBuilder& draft_;
  const std::vector<CatalogueProperty>& properties_;
  std::optional<SpecCursor> file_entry_, part_entry_, chosen_count_entry_, start_entry_;
  std::map<std::string, ColumnRequest> requests_;
  std::vector<int> counts_;
  std::vector<std::string> full_names_;
  study::CatalogueChoice choice_;
};

}  // namespace

std::vector<Field> CatalogueKeys::fields() {
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  return {{"catalogue", Presence::optional, store_in(catalogue)},
          {"columns", Presence::optional, store_in(columns)},
          {"count", Presence::optional, store_in(count)}};
}

CatalogueNumbers read_catalogue(const std::string& path, const CatalogueKeys& keys, StudyBuilder& draft,
                                const std::vector<CatalogueProperty>& properties) {
  study::CatalogueChoice choice = CatalogueReader(path, keys, draft, properties).read();
  CatalogueNumbers numbers;
  const auto row = static_cast<std::size_t>(choice.row);
  const bool has_counts =
      std::any_of(choice.counts.begin(), choice.counts.end(), [&](int n) { return n != choice.counts[0]; });
  if (has_counts) {
    choice.columns.push_back({"count", "1", std::vector<double>(choice.counts.begin(), choice.counts.end()), -1});
  } else {
    numbers.count = choice.counts[row];
  }
  for (study::CatalogueColumn& column : choice.columns) {
    Expression value = column.values[row];
    if (choice.is_free) {
      value = draft.add_input(column.values[row]);
      column.input = draft.recording->input_index(value);
    }
    if (column.name == "count")
      numbers.count = value;
    else
      numbers.numbers_.emplace_back(column.name, value);
  }
  draft.catalogue_nodes.push_back(&keys.catalogue->node());
  draft.study.catalogue_choices.push_back(std::move(choice));
  return numbers;
}

std::optional<Expression> choose_number(const CatalogueNumbers* catalogue, const std::string& name,
                                        const SpecCursor* key, StudyBuilder& draft, Dimension dimension,
                                        SignConstraint sign) {
  const std::optional<Expression> number = catalogue == nullptr ? std::nullopt : catalogue->find(name);
  if (number && key != nullptr)
    key->fail({.expected = fmt::format("{} from the catalogue or as a key", quote_for_message(name)), .found = "both"});
  if (number || key == nullptr) return number;
  return read_number(*key, draft, dimension, sign);
}

}  // namespace balance::specification
