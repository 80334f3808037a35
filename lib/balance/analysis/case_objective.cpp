#include "balance/analysis/case_objective.hpp"

#include "balance/analysis/figure_limits.hpp"
#include "balance/analysis/finite_trial.hpp"
#include "balance/analysis/objective.hpp"
#include "balance/base/extrema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace balance {

namespace {

/// Where a case's parameters and springs stand among those of all cases side by side.
struct CasePlace {
  std::vector<int> parameters;
  LooseSprings loose;
};

std::vector<CasePlace> places_of(const CaseSpace& space, const LooseSprings& loose) {
  // every list is one case after the other; parameters go by bearers of one sort, cases within them
  std::vector<CasePlace> places;
  std::vector<std::vector<Parameter>> lists;
  std::size_t spring = 0;
  for (const DesignSpace& one : space.cases) {
    CasePlace place;
    const std::size_t springs = one.start.mechanism.springs.size();
    for (std::size_t s = 0; s < springs && !loose.empty(); ++s) place.loose.push_back(loose[spring + s]);
    spring += springs;
    lists.push_back(list_parameters(one.start.mechanism, place.loose));
    place.parameters.resize(lists.back().size());
    places.push_back(std::move(place));
  }
  int next = 0;
  for (const Bearer bearer : {Bearer::body, Bearer::attachment, Bearer::disc, Bearer::spring})
    for (std::size_t k = 0; k < lists.size(); ++k)
      for (std::size_t p = 0; p < lists[k].size(); ++p)
        if (lists[k][p].bearer == bearer) places[k].parameters[p] = next++;
  return places;
}

Eigen::Index count_parameters(const std::vector<CasePlace>& places) {
  Eigen::Index total = 0;
  for (const CasePlace& place : places) total += static_cast<Eigen::Index>(place.parameters.size());
  return total;
}

/// What of the cases' values counts.
enum class Counts { largest, mean, least };

Counts counted(AcrossCases across) { return across == AcrossCases::mean ? Counts::mean : Counts::largest; }

class Cases {
 public:
  Cases(const CaseSpace& space, const std::vector<ObjectiveTerm>& terms, Counts counts, const LooseSprings& loose)
      : space_(space), counts_(counts), places_(places_of(space, loose)) {
    for (std::size_t k = 0; k < space.cases.size(); ++k)
      each_.push_back(build_objective(space.cases[k], terms, space.values(k, space.start_values()), places_[k].loose));
  }

  const std::vector<Objective>& each() const { return each_; }

  double of_parameters(const VectorX& parameters, VectorX* gradient) const {
    VectorX values(size()), own;
    if (gradient != nullptr) gradient->setZero(parameters.size());
    std::vector<VectorX> slopes(each_.size());
    for (std::size_t k = 0; k < each_.size(); ++k)
      values[static_cast<Eigen::Index>(k)] =
          each_[k].of_parameters(parameters(places_[k].parameters), gradient != nullptr ? &slopes[k] : nullptr);
    const Eigen::Index worst = counts_ == Counts::least ? min_index(values) : max_index(values);
    for (std::size_t k = 0; k < slopes.size() && gradient != nullptr; ++k)
      if (counts_ == Counts::mean)
        (*gradient)(places_[k].parameters) += slopes[k] / static_cast<double>(size());
      else if (static_cast<Eigen::Index>(k) == worst)
        (*gradient)(places_[k].parameters) = slopes[k];
    return together(values);
  }

  double of_variables(const VectorX& x) const {
    VectorX values(size());
    for (std::size_t k = 0; k < each_.size(); ++k) {
      const VectorX own = space_.values(k, x);
      values[static_cast<Eigen::Index>(k)] =
          each_[k].of_variables
              ? each_[k].of_variables(own)
              : each_[k].of_parameters(parameter_values(finite_trial(space_.cases[k], own).mechanism, places_[k].loose),
                                       nullptr);
    }
    return together(values);
  }

  std::string trouble(const VectorX& x) const {
    for (std::size_t k = 0; k < each_.size(); ++k)
      if (const std::string why = each_[k].trouble(space_.values(k, x)); !why.empty())
        return fmt::format("in case {}, {}", k + 1, why);
    return "";
  }

 private:
  Eigen::Index size() const { return static_cast<Eigen::Index>(each_.size()); }
  double together(const VectorX& values) const {
    if (!values.allFinite()) return NAN;
    if (counts_ == Counts::mean) return values.mean();
    return counts_ == Counts::least ? min_coefficient(values) : max_coefficient(values);
  }

  CaseSpace space_;
  Counts counts_;
  std::vector<CasePlace> places_;
  std::vector<Objective> each_;
};

/// The figure of one case as one of all parameters.
LinearFigure widened(LinearFigure figure, const CasePlace& place, Eigen::Index total) {
  if (figure.coefficients.size() > 0) {
    const VectorX own = figure.coefficients;
    figure.coefficients.setZero(total);
    figure.coefficients(place.parameters) = own;
  }
  for (PlaceRows& series : figure.series) {
    const MatrixX own = series.rows;
    series.rows.setZero(own.rows(), total + 1);
    series.rows(Eigen::all, place.parameters) = own.leftCols(own.cols() - 1);
    series.rows.col(total) = own.rightCols(1);
  }
  return figure;
}

using Figures = std::optional<std::vector<LinearFigure>>;

/// A sum of parameters that is never negative, as the peak of a series of one sample.
void make_series(LinearFigure& figure) {
  if (figure.coefficients.size() == 0) return;
  PlaceRows one;
  one.rows.setZero(1, figure.coefficients.size() + 1);
  one.rows.leftCols(figure.coefficients.size()) = figure.coefficients.transpose();
  one.components = 1;
  one.share = VectorX::Ones(1);
  figure = {figure.weight, {}, Figure::peak, {std::move(one)}};
}

/// The worst of one figure is one figure again: the worst of all series counts.
Figures join(std::vector<std::vector<LinearFigure>> each, AcrossCases across) {
  std::vector<LinearFigure> all;
  const double share = across == AcrossCases::mean ? 1.0 / static_cast<double>(each.size()) : 1;
  for (std::vector<LinearFigure>& figures : each)
    for (LinearFigure& figure : figures) {
      if (across == AcrossCases::worst) make_series(figure);
      if (across == AcrossCases::worst && !all.empty()) {
        std::move(figure.series.begin(), figure.series.end(), std::back_inserter(all.front().series));
        continue;
      }
      figure.weight *= share;
      all.push_back(std::move(figure));
    }
  return all;
}

}  // namespace

namespace {

Objective build(const CaseSpace& space, const std::vector<ObjectiveTerm>& terms, Counts counts,
                const LooseSprings& loose) {
  const auto cases = std::make_shared<const Cases>(space, terms, counts, loose);
  const std::vector<Objective>& each = cases->each();
  const auto all = [&](auto&& holds) { return std::all_of(each.begin(), each.end(), holds); };
  Objective objective;
  objective.name = each.front().name + (counts == Counts::mean ? " on average over the cases" : " in the worst case");
  objective.unit = each.front().unit;
  objective.convex = all([](const Objective& one) { return one.convex; });
  objective.size = all([](const Objective& one) { return one.size; });
  objective.lower_bound = each.front().lower_bound;
  if (all([](const Objective& one) { return bool(one.of_parameters); }))
    objective.of_parameters = [cases](const VectorX& p, VectorX* gradient) {
      return cases->of_parameters(p, gradient);
    };
  else
    objective.of_variables = [cases](const VectorX& x) { return cases->of_variables(x); };
  objective.trouble = [cases](const VectorX& x) { return cases->trouble(x); };
  return objective;
}

}  // namespace

Objective build_case_objective(const CaseSpace& space, const std::vector<ObjectiveTerm>& terms, AcrossCases across,
                               const LooseSprings& loose) {
  return build(space, terms, counted(across), loose);
}

std::vector<DesignLimit> build_case_limits(const CaseSpace& space, const std::vector<FigureLimit>& limits,
                                           const LooseSprings& loose) {
  std::vector<DesignLimit> built;
  for (const FigureLimit& limit : limits)
    built.push_back({limit.text,
                     build(space, limit.terms, limit.at_least ? Counts::least : counted(limit.across), loose),
                     limit.at_least, limit.bound});
  return built;
}

namespace {

using Bounded = std::function<std::optional<std::vector<BoundedFigures>>(const VectorX& x)>;

/// One limit in every case.
struct CaseLimit {
  AcrossCases across;
  std::vector<Bounded> each;
};

/// Limits on means add up to one, of all cases' figures; those on the worst value are as many as cases.
void add_limit(std::vector<BoundedFigures> each, AcrossCases across, std::vector<BoundedFigures>& all) {
  if (across == AcrossCases::worst) {
    std::move(each.begin(), each.end(), std::back_inserter(all));
    return;
  }
  BoundedFigures mean{{}, each.front().bound};
  for (BoundedFigures& own : each)
    for (LinearFigure& figure : own.figures) {
      figure.weight /= static_cast<double>(each.size());
      mean.figures.push_back(std::move(figure));
    }
  all.push_back(std::move(mean));
}

}  // namespace

Bounded build_case_bounded(const CaseSpace& space, const std::vector<FigureLimit>& limits, const LooseSprings& loose,
                           int& known) {
  const std::vector<CasePlace> places = places_of(space, loose);
  std::vector<CaseLimit> built;
  for (const FigureLimit& limit : limits) {
    CaseLimit one{limit.across, {}};
    int is_known = 0;
    for (std::size_t k = 0; k < space.cases.size(); ++k)
      one.each.push_back(build_bounded(space.cases[k], {limit}, places[k].loose, is_known));
    if (is_known > 0) built.push_back(std::move(one));
  }
  known = static_cast<int>(built.size());
  if (built.empty()) return {};
  return [space, built, places,
          total = count_parameters(places)](const VectorX& x) -> std::optional<std::vector<BoundedFigures>> {
    std::vector<BoundedFigures> all;
    for (const CaseLimit& limit : built) {
      std::vector<BoundedFigures> each;
      for (std::size_t k = 0; k < limit.each.size(); ++k) {
        auto own = limit.each[k](space.values(k, x));
        if (!own) return std::nullopt;
        for (LinearFigure& figure : own->front().figures) figure = widened(std::move(figure), places[k], total);
        each.push_back(std::move(own->front()));
      }
      add_limit(std::move(each), limit.across, all);
    }
    return all;
  };
}

std::function<Figures(const VectorX& x)> build_case_figures(const CaseSpace& space,
                                                            const std::vector<ObjectiveTerm>& terms, AcrossCases across,
                                                            const LooseSprings& loose, FigureSamples samples) {
  if (across == AcrossCases::worst && terms.size() > 1) return {};
  const std::vector<CasePlace> places = places_of(space, loose);
  const Eigen::Index total = count_parameters(places);
  std::vector<std::function<Figures(const VectorX&)>> each;
  for (std::size_t k = 0; k < space.cases.size(); ++k) {
    each.push_back(build_figures(space.cases[k], terms, places[k].loose, samples));
    if (!each.back()) return {};
  }
  return [space, each, places, total, across](const VectorX& x) -> Figures {
    std::vector<std::vector<LinearFigure>> found;
    for (std::size_t k = 0; k < each.size(); ++k) {
      Figures own = each[k](space.values(k, x));
      if (!own) return std::nullopt;
      for (LinearFigure& figure : *own) figure = widened(std::move(figure), places[k], total);
      found.push_back(std::move(*own));
    }
    return join(std::move(found), across);
  };
}

}  // namespace balance
