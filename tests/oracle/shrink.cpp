#include "tests/oracle/shrink.h"

#include <cmath>

namespace lucerna::oracle {
namespace {

using Case = std::pair<World, Question>;

/// The same question after shape `i` is left out.  Its source is at `rank` among the sources.
void leave_out(int i, int rank, Question& q) {
  for (Place* p : {&q.from, &q.to}) {
    if (p->on > i) --p->on;
  }
  if (rank >= 0 && q.source > rank) --q.source;
}

/// Three digits of each coordinate.
Vec rounded(const Vec& v) {
  const auto one = [](Real x) {
    if (x == 0) return x;
    const double unit =
        std::pow(10.0, std::floor(std::log10(static_cast<double>(std::fabs(x)))) - 2);
    return static_cast<Real>(std::round(static_cast<double>(x) / unit) * unit);
  };
  return {one(v.x), one(v.y), one(v.z)};
}

/// All scenes that are one step smaller.
std::vector<Case> smaller(const World& world, const Question& question) {
  std::vector<Case> cases;
  const int lights = static_cast<int>(world.lights.size());
  int rank = lights;
  for (int i = 0; i < static_cast<int>(world.shapes.size()); ++i) {
    const bool emits = world.shapes[static_cast<std::size_t>(i)].radiance > 0;
    const int source = emits ? rank++ : -1;
    if (question.from.on == i || question.to.on == i || (emits && question.source == source))
      continue;
    Case c{world, question};
    c.first.shapes.erase(c.first.shapes.begin() + i);
    leave_out(i, source, c.second);
    cases.push_back(c);
    if (!emits) continue;
    Case dark{world, question};
    dark.first.shapes[static_cast<std::size_t>(i)].radiance = 0;
    leave_out(static_cast<int>(world.shapes.size()), source, dark.second);
    cases.push_back(dark);
  }
  for (int i = 0; i < lights; ++i) {
    if (question.source == i) continue;
    Case c{world, question};
    c.first.lights.erase(c.first.lights.begin() + i);
    leave_out(static_cast<int>(world.shapes.size()), i, c.second);
    cases.push_back(c);
  }
  return cases;
}

/// All scenes with one thing simpler.
std::vector<World> simpler(const World& world, const Question& question) {
  std::vector<World> worlds;
  const auto add = [&](auto&& change) {
    World copy = world;
    if (change(copy)) worlds.push_back(std::move(copy));
  };
  for (std::size_t i = 0; i < world.shapes.size(); ++i) {
    // Places stay on their shapes.
    const int number = static_cast<int>(i);
    if (question.from.on == number || question.to.on == number) continue;
    add([&](World& w) { return length(std::exchange(w.shapes[i].moves, {})) > 0; });
    add([&](World& w) { return !std::exchange(w.shapes[i].picture, {}).empty(); });
    add([&](World& w) { return std::exchange(w.shapes[i].two_sided, false); });
    add([&](World& w) {
      bool changed = false;
      for (Vec& p : w.shapes[i].at) {
        const Vec before = std::exchange(p, rounded(p));
        changed = changed || length(before - p) > 0;
      }
      return changed;
    });
  }
  for (std::size_t i = 0; i < world.lights.size(); ++i) {
    add([&](World& w) { return length(std::exchange(w.lights[i].moves, {})) > 0; });
    add([&](World& w) {
      const Vec before = std::exchange(w.lights[i].at, rounded(w.lights[i].at));
      return length(before - w.lights[i].at) > 0;
    });
  }
  return worlds;
}

}  // namespace

Case shrink(World world, Question question,
            const std::function<bool(const World& world, const Question& question)>& fails) {
  const auto step = [&] {
    for (const auto& [w, q] : smaller(world, question)) {
      if (!fails(w, q)) continue;
      world = w;
      question = q;
      return true;
    }
    for (const World& w : simpler(world, question)) {
      if (!fails(w, question)) continue;
      world = w;
      return true;
    }
    return false;
  };
  // Each step removes something, so this ends.
  while (step()) {
  }
  return {world, question};
}

}  // namespace lucerna::oracle
