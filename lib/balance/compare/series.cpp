#include "balance/compare/series.hpp"

#include "balance/result/round_off.hpp"
#include "balance/result/tracks.hpp"

namespace balance {

std::vector<QuantitySeries> list_series(const RunResult& result) {
  std::vector<QuantitySeries> all;
  for (const MetricSeries& track : list_metric_series(result)) {
    const Samples& samples = result.*track.array;
    if (samples.rows() > 0 && samples.rows() == result.time.size())
      all.push_back(
          {track.quantity, &samples, track.first, track.count, column_round_off(result, track.array, track.first)});
  }
  return all;
}

}  // namespace balance
