#include "balance/design/context.hpp"

namespace balance::designing {

Context::Context(const DesignProblem& p)
    : problem(p),
      box(p.variables),
      survey(designing::survey(box, p)),
      options(p.options),
      map(box, p, survey),
      physical(map, survey, map.exact(box.start())) {
  options.loose_springs = survey.loose;
}

}  // namespace balance::designing
