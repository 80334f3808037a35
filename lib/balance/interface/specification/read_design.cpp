#include "balance/interface/specification/read_design.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/part_insertion.hpp"
#include "balance/interface/specification/read_all_different.hpp"
#include "balance/interface/specification/read_load_cases.hpp"
#include "balance/interface/specification/read_objective.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/interface/specification/yaml_source.hpp"
#include "balance/motion/study/study.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::specification {

namespace {

const std::vector<std::string> optional_sections = {"counterweights", "discs", "springs"};

std::vector<std::string> names_in_section(const std::string& section, const StudyBuilder& draft) {
  std::vector<std::string> names;
  const MechanismOf<Expression>& mechanism = draft.mechanism();
  if (section == "discs")
    for (const auto& disc : mechanism.discs) names.push_back(disc.name);
  else if (section == "springs")
    for (const auto& spring : mechanism.springs) names.push_back(spring.name);
  else
    for (const auto& one : mechanism.attachments)
      if (one.kind == AttachmentKind::counterweight) names.push_back(one.name);
  return names;
}

/// False for a designed spec: its free numbers have become plain numbers, and elements may be left out.
bool has_free_numbers(const StudyBuilder& draft) {
  return !draft.free_numbers.empty() || !draft.parameters.free_numbers().empty();
}

int read_max_count(const SpecCursor& at, StudyBuilder& draft, long element_count) {
  if (at.is_scalar() && at.node().text == "least") return -1;
  const std::string what = fmt::format("the number to keep at most, 0 to {}, or least", element_count);
  if (!at.is_scalar()) at.fail_expected(what);
  const double value = draft.parameters.evaluate(at).value();
  const long maximum = has_free_numbers(draft) ? element_count : static_cast<long>(max_members);
  if (value != static_cast<double>(static_cast<long>(value)) || value < 0 || value > static_cast<double>(maximum))
    at.fail_expected(what);
  return static_cast<int>(value);
}

void read_element_names(const SpecCursor& at, const StudyBuilder& draft, study::CardinalityRequest& request) {
  const std::vector<std::string> names = names_in_section(request.section, draft);
  request.elements.clear();
  request.is_whole_section = false;
  read_each(at.items("names of " + request.section), [&](const SpecCursor& item) {
    const std::string& name = item.read_word("a name");
    if (!has_free_numbers(draft)) return;
    if (std::find(names.begin(), names.end(), name) == names.end()) {
      if (!draft.is_mechanism_valid) throw CascadingError();
      fail_expected_one_of(item, "one of the " + request.section, names);
    }
    for (const study::OptionalElementText& other : request.elements)
      if (other.name == name) item.fail({.expected = "each name only once", .found = item.describe_found() + " again"});
    request.elements.push_back({name});
  });
  if (at.node().items.empty()) at.fail_expected("at least one name");
}

study::CardinalityRequest read_cardinality_request(const std::string& section, const SpecCursor& at,
                                                   StudyBuilder& draft) {
  study::CardinalityRequest request{section, {}, true, -1};
  for (const std::string& name : names_in_section(section, draft)) request.elements.push_back({name});
  if (has_free_numbers(draft) && draft.is_mechanism_valid && request.elements.empty())
    at.fail({.expected = section + " to choose from", .found = "none in the spec"});
  if (!at.is_map()) {
    request.max_count = read_max_count(at, draft, static_cast<long>(request.elements.size()));
    return request;
  }
  std::optional<SpecCursor> max_count_entry;
  const bool is_valid =
      read_fields(at, "a number, least or {from: names, most: …}",
                  {{"from", Presence::optional, [&](const SpecCursor& c) { read_element_names(c, draft, request); }},
                   {"most", Presence::optional, [&](const SpecCursor& c) { max_count_entry = c; }}});
  if (!is_valid) throw CascadingError();
  if (max_count_entry)
    request.max_count = read_max_count(*max_count_entry, draft, static_cast<long>(request.elements.size()));
  return request;
}

/// Finds the text of an entry in the document.
class EntryText {
 public:
  explicit EntryText(const std::string& text) : source_(text) {}

  /// Empty if the entry cannot be cut out, for example because aliases repeat its content.
  Span find_span(const YamlNode& map, std::size_t index) const {
    const YamlNode &key = map.keys[index], &value = map.items[index];
    if (map.alias != 0 || has_anchor(value)) return {};
    const std::size_t begin = source_.span(key).begin;
    const std::size_t end = std::max(source_.span(key).end, source_.span(value).end);
    return map.is_flow ? between_commas(map, index, begin, end) : whole_lines(begin, end);
  }

 private:
  static bool has_anchor(const YamlNode& node) {
    return node.anchor != 0 || std::any_of(node.items.begin(), node.items.end(), has_anchor);
  }

  /// Up to the next entry; the last one with a comma behind it, if there is one.
  Span between_commas(const YamlNode& map, std::size_t index, std::size_t begin, std::size_t end) const {
    if (index + 1 < map.keys.size()) return {begin, source_.span(map.keys[index + 1]).begin};
    const std::size_t after = source_.skip_blank(end);
    if (after < source_.text().size() && source_.text()[after] == ',') end = after + 1;
    return {begin, end};
  }

  Span whole_lines(std::size_t begin, std::size_t end) const {
    begin -= source_.indentation(begin).size();
    if (begin > 0 && !source_.is_break(begin - 1)) return {};
    end = source_.line_end(end);
    if (source_.text().compare(end, 2, "\r\n") == 0) return {begin, end + 2};
    return {begin, std::min(end + 1, source_.text().size())};
  }

  SourceText source_;
};

}  // namespace

std::vector<study::CardinalityRequest> read_cardinality_requests(const SpecCursor& at, StudyBuilder& draft) {
  std::vector<study::CardinalityRequest> requests;
  std::vector<Field> fields;
  for (const std::string& section : optional_sections)
    fields.push_back({section, Presence::optional, [&requests, &draft, section](const SpecCursor& c) {
                        requests.push_back(read_cardinality_request(section, c, draft));
                      }});
  if (!read_fields(at, "elements to choose from {counterweights, discs, springs}", fields)) throw CascadingError();
  if (requests.empty()) at.fail_missing(optional_sections);
  return requests;
}

void find_optional_element_texts(const YamlNode& root, Study& study) {
  const EntryText entry_text(study.spec_text);
  for (study::CardinalityRequest& request : study.design.cardinality) {
    const YamlNode* section = find_entry(root, request.section);
    if (section == nullptr) continue;
    for (std::size_t i = 0; i < section->keys.size(); ++i) {
      const std::string& name = section->keys[i].text;
      const auto element = std::find_if(request.elements.begin(), request.elements.end(),
                                        [&](const study::OptionalElementText& one) { return one.name == name; });
      if (element == request.elements.end()) continue;
      const Span span = entry_text.find_span(*section, i);
      element->begin = span.begin;
      element->end = span.end;
    }
  }
}

// The request for a design: goals, figures, limits and search.

namespace {

std::string read_search_method(const SpecCursor& at, const std::string& what, const std::vector<std::string>& names) {
  return names[at.read_choice(what, names)];
}

void read_search(const SpecCursor& at, StudyBuilder& draft, study::SearchOptions& search) {
  read_fields(
      at, "search settings {global, local, seed, restarts, evaluations, seconds}",
      {{"global", Presence::optional,
        [&](const SpecCursor& c) {
          search.global = read_search_method(c, "a global method", study::global_methods());
        }},
       {"local", Presence::optional,
        [&](const SpecCursor& c) { search.local = read_search_method(c, "a local method", study::local_methods()); }},
       {"seed", Presence::optional,
        [&](const SpecCursor& c) {
          search.seed = static_cast<std::uint64_t>(read_integer(c, draft, 0, study::max_seed));
        }},
       {"restarts", Presence::optional,
        [&](const SpecCursor& c) { search.max_restarts = static_cast<int>(read_integer(c, draft, 1, 10'000)); },
        "starts"},
       {"evaluations", Presence::optional,
        [&](const SpecCursor& c) {
          search.max_evaluations = static_cast<int>(read_integer(c, draft, 1, 100'000'000));
        }},
       {"seconds", Presence::optional, [&](const SpecCursor& c) {
          if (!c.is_scalar()) c.fail_expected("a number of seconds");
          search.max_time = draft.parameters.evaluate(c).value();
          if (!(search.max_time > 0))
            c.fail({.kind = "must be positive",
                    .expected = "a number of seconds > 0",
                    .found = fmt::format("{}", search.max_time)});
        }}});
}

}  // namespace

void read_design(const SpecCursor& section, StudyBuilder& draft) {
  study::DesignRequest& request = draft.study.design;
  std::optional<SpecCursor> front_entry, cases_entry, across_entry, adapt_entry, different_entry;
  const Mechanism* mechanism = draft.is_mechanism_valid ? &draft.study.mechanism : nullptr;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  read_fields(
      section,
      "design settings {goal, minimize, front, subject_to, choose, all_different, assembly_mode, search, for, across, "
      "adapt}",
      {{"goal", Presence::optional, [&](const SpecCursor& c) { request.goals = read_goals(c, mechanism); }},
       {"minimize", Presence::optional,
        [&](const SpecCursor& c) { request.minimize = read_objective_terms(c, draft.parameters, draft.study); }},
       {"front", Presence::optional, store_in(front_entry)},
       {"subject_to", Presence::optional,
        [&](const SpecCursor& c) { request.subject_to = read_figure_limits(c, draft); }},
       {"choose", Presence::optional,
        [&](const SpecCursor& c) { request.cardinality = read_cardinality_requests(c, draft); }},
       {"all_different", Presence::optional, store_in(different_entry)},
       {"assembly_mode", Presence::optional,
        [&](const SpecCursor& c) {
          request.keeps_assembly_mode = c.read_choice("which assembly modes are allowed", {"start", "any"}) == 0;
        }},
       {"search", Presence::optional, [&](const SpecCursor& c) { read_search(c, draft, request.search); }},
       {"for", Presence::optional, store_in(cases_entry)},
       {"across", Presence::optional, store_in(across_entry)},
       {"adapt", Presence::optional, store_in(adapt_entry)}});
  if (front_entry) draft.problems.collect([&] { request.front = read_pareto_request(*front_entry, draft); });
  if (front_entry && !request.minimize.empty())
    draft.problems.collect([&] { front_entry->fail({.expected = "no 'minimize' with a front", .found = "both"}); });
  if (cases_entry) draft.problems.collect([&] { read_load_cases(*cases_entry, draft, request.cases); });
  for (const auto* slot : {&across_entry, &adapt_entry})
    if (*slot && !cases_entry)
      draft.problems.collect([&] { (*slot)->fail({.expected = "'for' (the load cases) as well", .found = "none"}); });
  if (across_entry) draft.problems.collect([&] { request.cases.aggregation = read_case_aggregation(*across_entry); });
  if (adapt_entry) draft.problems.collect([&] { draft.adapted = read_adapted(*adapt_entry, draft); });
  if (different_entry)
    draft.problems.collect([&] { draft.all_different = read_all_different(*different_entry, draft); });
}

namespace {

constexpr long min_pareto_points = 3, max_pareto_points = 200;

/// A figure without a weight > 0 cannot be traded off.
void require_weight(const SpecCursor& at, const std::vector<ObjectiveTerm>& terms) {
  for (const ObjectiveTerm& term : terms)
    if (term.weight > 0) return;
  at.fail({.expected = "a figure with a weight > 0", .found = "none"});
}

void read_figures(const SpecCursor& at, StudyBuilder& draft, study::ParetoRequest& request) {
  const std::string what = "two or three figures, such as [added-mass, {rms: shaking_moment}]";
  const std::vector<SpecCursor> items = at.items(what);
  if (items.size() < 2 || items.size() > 3)
    at.fail({.expected = what, .found = items.size() == 1 ? "one" : fmt::format("{}", items.size())});
  read_each(items, [&](const SpecCursor& item) {
    request.figures.push_back(read_objective_terms(item, draft.parameters, draft.study));
    require_weight(item, request.figures.back());
  });
}

}  // namespace

study::ParetoRequest read_pareto_request(const SpecCursor& at, StudyBuilder& draft) {
  study::ParetoRequest request;
  if (!at.is_map()) {
    read_figures(at, draft, request);
    return request;
  }
  read_fields(at, "a trade-off {of, points}",
              {{"of", Presence::required, [&](const SpecCursor& c) { read_figures(c, draft, request); }},
               {"points", Presence::optional, [&](const SpecCursor& c) {
                  request.max_points = static_cast<int>(read_integer(c, draft, min_pareto_points, max_pareto_points));
                }}});
  return request;
}

std::vector<Goal> read_goals(const SpecCursor& at, const Mechanism* mechanism) {
  std::vector<Goal> goals;
  const auto fail = [](const SpecCursor& c, const study::GoalMistake& mistake) {
    c.fail({.expected = mistake.expected, .found = mistake.found, .hint = mistake.hint});
  };
  const auto read_one = [&](const SpecCursor& c) {
    const std::string& text = c.read_word("a goal (" + join_alternatives(study::goal_names()) + ")");
    const std::optional<Goal> found = study::find_goal(text);
    if (!found) fail(c, study::explain_goal_mistake(text));
    const Goal& goal = *found;
    if (mechanism != nullptr)
      if (const auto mistake = study::find_goal_mistake(goal, *mechanism)) fail(c, *mistake);
    if (std::find(goals.begin(), goals.end(), goal) != goals.end())
      c.fail({.expected = "each goal only once", .found = fmt::format("{} again", c.describe_found())});
    goals.push_back(goal);
  };
  if (!at.is_list()) {
    read_one(at);
    return goals;
  }
  for (const SpecCursor& item : at.items("a list of goals")) at.problems().collect([&] { read_one(item); });
  if (at.node().items.empty()) at.fail_expected("at least one goal");
  return goals;
}

}  // namespace balance::specification
