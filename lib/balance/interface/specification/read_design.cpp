#include "balance/interface/specification/read_design.hpp"

#include "balance/foundation/base/spelling.hpp"
#include "balance/interface/specification/part_insertion.hpp"
#include "balance/interface/specification/read_all_different.hpp"
#include "balance/interface/specification/read_load_cases.hpp"
#include "balance/interface/specification/read_objective.hpp"
#include "balance/interface/specification/read_speeds.hpp"
#include "balance/interface/specification/read_temporary_payloads.hpp"
#include "balance/interface/specification/study_builder.hpp"
#include "balance/interface/specification/yaml_source.hpp"
#include "balance/mechanics/model/eccentric_disc.hpp"
#include "balance/motion/study/study.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace balance::specification {

namespace {

const std::vector<std::string> optional_sections = {"counterweights", "discs", "springs"};

std::vector<std::string> names_in_section(const std::string& section, const StudyBuilder& draft) {
  std::vector<std::string> names;
  const MechanismOf<Expression>& mechanism = draft.mechanism();
  if (section == "discs") {
    for (const auto& disc : mechanism.discs) names.push_back(disc.name);
    for (const auto& one : mechanism.attachments)
      if (model::is_eccentric_disc(mechanism, one)) names.push_back(one.name);
  } else if (section == "springs")
    for (const auto& spring : mechanism.springs) names.push_back(spring.name);
  else
    for (const auto& one : mechanism.attachments)
      if (one.kind == AttachmentKind::counterweight && !model::is_eccentric_disc(mechanism, one))
        names.push_back(one.name);
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

namespace {

/// Whether the point follows when its body's numbers change: named points do, if their name is clear from their place.
bool follows_changes(const model::GeneralisedSpeedTermOf<Expression>& term, const StudyBuilder& draft) {
  const auto is_variable = [&](const Expression& number) { return is_variable_number(number, draft); };
  if (std::none_of(term.position.begin(), term.position.end(), is_variable)) return true;
  const Vector3 place = values_of(term.position);
  const auto& points = draft.mechanism().bodies[static_cast<std::size_t>(term.body)].points;
  return !place.isZero(0) && std::count_if(points.begin(), points.end(),
                                           [&](const auto& point) { return values_of(point.position) == place; }) == 1;
}

/// Speeds in whose derivatives the goals are stated. Their factors do not change with the design.
std::vector<model::GeneralisedSpeed> read_goal_speeds(const SpecCursor& at, StudyBuilder& draft) {
  std::vector<model::GeneralisedSpeed> speeds;
  const auto is_variable = [&](const Expression& number) { return is_variable_number(number, draft); };
  const auto read_one = [&](const Member& member) {
    const auto speed = read_speed(member, SpeedUse::quasi_velocity, draft);
    for (const auto& term : speed.terms) {
      const std::vector<Expression>& of_pose = term.pose_factor.parameters;
      if (is_variable(term.factor) || std::any_of(of_pose.begin(), of_pose.end(), is_variable))
        member.value.fail({.expected = "factors of numbers that no design changes", .found = "a free number"});
      if (!follows_changes(term, draft))
        member.value.fail(
            {.expected = "a point whose place is fixed, or a named point away from all others of its body",
             .found = "a free place"});
    }
    speeds.push_back(to_numbers(speed));
  };
  for (const Member& member : list_named_members(at, "a mapping of speeds"))
    draft.problems.collect([&] { read_one(member); });
  if (speeds.empty() && !draft.problems.is_invalid(at.path()))
    at.fail({.expected = "at least one speed", .found = "none"});
  return speeds;
}

}  // namespace

void read_design(const SpecCursor& section, StudyBuilder& draft) {
  study::DesignRequest& request = draft.study.design;
  std::optional<SpecCursor> front_entry, cases_entry, across_entry, adapt_entry, different_entry;
  const Study* study = draft.is_mechanism_valid ? &draft.study : nullptr;
  const auto store_in = [](std::optional<SpecCursor>& slot) { return [&slot](const SpecCursor& c) { slot = c; }; };
  read_fields(
      section,
      "design settings {goal, speeds, minimize, front, subject_to, choose, all_different, assembly_mode, search, for, "
      "across, "
      "adapt}",
      {{"goal", Presence::optional, [&](const SpecCursor& c) { request.goals = read_goals(c, study); }},
       {"speeds", Presence::optional, [&](const SpecCursor& c) { request.speeds = read_goal_speeds(c, draft); }},
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

/// The trajectories that figures of the design name, else all that do not depend on the mechanism.
std::vector<std::string> list_design_motions(const Study& study) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const ObjectiveTerm& term : study.design.minimize) add(term.trajectory);
  for (const study::FigureLimit& limit : study.design.subject_to)
    for (const ObjectiveTerm& term : limit.terms) add(term.trajectory);
  for (const auto& terms : study.design.front.figures)
    for (const ObjectiveTerm& term : terms) add(term.trajectory);
  if (!names.empty()) return names;
  for (const Trajectory& trajectory : study.trajectories)
    if (!is_mechanism_dependent(trajectory) && trajectory.adaptations.empty()) add(trajectory.name);
  return names;
}

}  // namespace

void limit_spring_travel(Study& study) {
  const bool has_design = !study.design.goals.empty() || !study.design.minimize.empty() ||
                          !study.design.subject_to.empty() || study.design.front;
  const bool has_travel = std::any_of(study.mechanism.springs.begin(), study.mechanism.springs.end(),
                                      [](const Spring& spring) { return spring.has_travel(); });
  if (!has_design || !has_travel) return;
  const std::vector<std::string> motions = list_design_motions(study);
  for (const Spring& spring : study.mechanism.springs) {
    if (!spring.has_travel()) continue;
    for (const std::string& motion : motions) {
      ObjectiveTerm term;
      term.figure = Statistic::minimum;
      term.quantity = "spring_margin[" + spring.name + "]";
      term.trajectory = motion;
      const bool is_stated = std::any_of(
          study.design.subject_to.begin(), study.design.subject_to.end(), [&](const study::FigureLimit& limit) {
            return limit.is_lower && limit.terms.size() == 1 && limit.terms[0].quantity == term.quantity &&
                   limit.terms[0].trajectory == motion && limit.terms[0].figure == Statistic::minimum &&
                   limit.bound >= 0;
          });
      if (is_stated) continue;
      study::FigureLimit limit;
      limit.text = fmt::format("minimum({}, {}) >= 0", term.quantity, motion);
      limit.terms = {term};
      limit.is_lower = true;
      limit.unit = "m";
      study.design.subject_to.push_back(std::move(limit));
    }
  }
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

namespace {

class GoalReader {
 public:
  explicit GoalReader(const Study* study) : study_(study) {}

  void read(const SpecCursor& at) {
    if (at.is_map()) return read_orders(at);
    const std::string& text = at.read_word("a goal (" + join_alternatives(study::goal_names()) +
                                           ", or {orders: {shaking_force: [1, 2]}, along: run})");
    const std::optional<Goal> goal = study::find_goal(text);
    if (!goal) fail(at, study::explain_goal_mistake(text));
    if (const auto mistake = find_mistake(*goal)) fail(at, *mistake);
    add(at, *goal);
  }
  const std::vector<Goal>& goals() const { return goals_; }

 private:
  [[noreturn]] static void fail(const SpecCursor& at, const study::GoalMistake& mistake) {
    at.fail({.expected = mistake.expected, .found = mistake.found, .hint = mistake.hint});
  }

  std::optional<study::GoalMistake> find_mistake(const Goal& goal) const {
    if (study_ == nullptr) return std::nullopt;
    std::optional<study::GoalMistake> mistake = study::find_goal_mistake(goal, study_->mechanism);
    return mistake ? mistake : study::find_motion_mistake(goal, study_->trajectories);
  }

  void add(const SpecCursor& at, const Goal& goal) {
    if (std::find(goals_.begin(), goals_.end(), goal) != goals_.end())
      at.fail({.expected = "each goal only once", .found = fmt::format("{} again", at.describe_found())});
    goals_.push_back(goal);
  }

  /// `{orders: {shaking_force: [1, 2], shaking_moment: 1}, along: run}`
  void read_orders(const SpecCursor& at) {
    std::optional<SpecCursor> orders, along;
    const bool is_valid = read_fields(at, "orders that must vanish {orders: {shaking_force: [1, 2]}, along: run}",
                                      {{"orders", Presence::required, [&](const SpecCursor& c) { orders = c; }},
                                       {"along", Presence::required, [&](const SpecCursor& c) { along = c; }}});
    if (!is_valid) throw CascadingError();
    Goal goal{.kind = GoalKind::order};
    goal.order.trajectory =
        study_ != nullptr ? read_trajectory_name(*along, *study_) : along->read_word("a trajectory's name");
    const std::vector<Member> entries =
        list_members(*orders, "quantities with their orders {shaking_force: [1, 2], shaking_moment: [1]}");
    if (entries.empty())
      orders->fail(
          {.expected = "at least one quantity with its orders, such as shaking_force: [1, 2]", .found = "none"});
    for (const Member& entry : entries)
      at.problems().collect([&] {
        goal.order.quantity = entry.name;
        goal.order.part = results::OrderPart::whole;
        if (const auto mistake = find_mistake_of_quantity(goal)) fail(entry.key, *mistake);
        if (const auto mistake =
                study_ == nullptr ? std::nullopt : study::find_motion_mistake(goal, study_->trajectories))
          fail(*along, *mistake);
        read_parts(entry.value, goal);
      });
  }

  std::optional<study::GoalMistake> find_mistake_of_quantity(const Goal& goal) const {
    return study_ == nullptr ? std::nullopt : study::find_goal_mistake(goal, study_->mechanism);
  }

  /// `[1, 2]`, or `{forward: [1], backward: [2]}` of a force in the plane.
  void read_parts(const SpecCursor& at, Goal goal) {
    if (!at.is_map()) return read_numbers(at, goal);
    std::vector<Field> fields;
    using enum results::OrderPart;
    for (const auto& [name, part] : {std::pair{"forward", forward}, std::pair{"backward", backward}})
      fields.push_back({name, Presence::optional, [this, goal, part = part](const SpecCursor& c) mutable {
                          goal.order.part = part;
                          if (const auto mistake = find_mistake_of_quantity(goal)) fail(c, *mistake);
                          read_numbers(c, goal);
                        }});
    if (!read_fields(at, "orders [1, 2], or those of each direction {forward: [1], backward: [2]}", fields))
      throw CascadingError();
    if (at.node().keys.empty()) at.fail_missing({"forward", "backward"});
  }

  void read_numbers(const SpecCursor& at, Goal goal) {
    const auto read_one = [&](const SpecCursor& c) {
      const std::string& text = c.read_word("an order, such as 2 or 1/2");
      const std::optional<double> number = study::find_order_number(text);
      if (!number) c.fail({.expected = "an order, a number above 0 such as 2 or 1/2", .found = c.describe_found()});
      goal.order.number = *number;
      add(c, goal);
    };
    if (!at.is_list()) return read_one(at);
    for (const SpecCursor& item : at.items("a list of orders")) at.problems().collect([&] { read_one(item); });
    if (at.node().items.empty()) at.fail_expected("at least one order");
  }

  const Study* study_;
  std::vector<Goal> goals_;
};

}  // namespace

std::vector<Goal> read_goals(const SpecCursor& at, const Study* study) {
  GoalReader reader(study);
  if (!at.is_list()) {
    reader.read(at);
    return reader.goals();
  }
  for (const SpecCursor& item : at.items("a list of goals")) at.problems().collect([&] { reader.read(item); });
  if (at.node().items.empty()) at.fail_expected("at least one goal");
  return reader.goals();
}

}  // namespace balance::specification
