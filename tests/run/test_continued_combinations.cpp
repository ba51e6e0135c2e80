// Saved and continued with the same bits: all combinations of what a case can choose. There are tens of thousands, of which each run takes
// every 199th; all of them: MATPOINT_EVERY=1 build/release/bin/test_run --gtest_filter='Combinations*'.
#include <cstdlib>
#include <random>

#include "core/parallel.hpp"
#include "support/from_toml.hpp"
#include "support/law_tables.hpp"
#include "support/solver_case.hpp"

namespace matpoint::test {
namespace {

/// Of all laws, as they stand in a case: soft ones, with what their declarations require.
std::vector<std::string> laws() {
  std::vector<std::string> all;
  for (const auto& entry : material_registry().entries()) {
    Input table = Input::table();
    table.set("type", Input::string(entry.name));
    table = sample_table(
        entry.parameters, 2,
        [&](const Input& values) {
          material_registry().read(values, {2, ""}, "material");
        },
        table);
    std::vector<std::string> words;
    for (const auto& [name, value] : table.entries()) words.push_back(fmt::format("{} = {}", name, value.text()));
    all.push_back(fmt::format("{{ {} }}", fmt::join(words, ", ")));
  }
  return all;
}

std::string box(int dim, Real lower, Real upper, Real height) {
  return dim == 2 ? fmt::format("region = {{ type = \"box\", lower = [{}, 0], upper = [{}, {}] }}\n", lower, upper, height)
                  : fmt::format("region = {{ type = \"box\", lower = [{}, 0.25, 0], upper = [{}, 0.5, {}] }}\n", lower, upper, height);
}
std::string top(int dim, int cells) {
  return dim == 2 ? fmt::format("gravity = [0.3, -9.81]\n[grid]\nupper = [1, 1]\ncells = [{0}, {0}]\n", cells)
                  : fmt::format("dim = 3\ngravity = [0.3, 0.1, -9.81]\n[grid]\nupper = [1, 1, 1]\ncells = [{0}, {0}, {0}]\n", cells);
}
std::string velocity(int dim, Real x, Real up) {
  return dim == 2 ? fmt::format("velocity = [{}, {}]\n", x, up) : fmt::format("velocity = [{}, 0.05, {}]\n", x, up);
}
const std::string rubber = "{ type = \"neo_hookean\", density = 1000, youngs_modulus = 3e4, poissons_ratio = 0.3 }\n";
std::string floor_of(int dim) { return dim == 2 ? "[[boundary]]\nside = \"bottom\"\n" : "[[boundary]]\nside = \"front\"\n"; }

/// One of all combinations of what is chosen from: the digits of a number.
class Choice {
 public:
  explicit Choice(long number) : number_(number) {}
  template <class T>
  const T& of(const std::vector<T>& all) {
    const auto size = static_cast<long>(all.size());
    const T& chosen = all[static_cast<std::size_t>(number_ / count_ % size)];
    count_ *= size;
    return chosen;
  }
  std::string of_names(const std::vector<std::string>& all) {
    const std::string& chosen = of(all);
    name_ += chosen + " ";
    return chosen;
  }
  /// Of combinations.
  long count() const { return count_; }
  const std::string& name() const { return name_; }

 private:
  long number_;
  long count_ = 1;
  std::string name_;
};

/// Runs cases that `make` writes, some or all of them, each with a cut at a step of its own. At most one of `share_to_fail` may fail at
/// once.
template <class Make>
void continue_each(int steps, std::size_t share_to_fail, Make&& make) {
  const char* const given = std::getenv("MATPOINT_EVERY");
  const long every = given != nullptr ? std::max(1, std::atoi(given)) : 199;
  long tried = 0, refused = 0, count = 1;
  std::vector<std::string> failed;
  for (long number = every / 2; number < count || number == every / 2; number += every) {
    Choice choice(number);
    const std::string text = make(choice);
    count = choice.count();
    std::optional<Simulation> whole, second;
    std::optional<Case> problem;
    try {
      problem = read(text);
      whole.emplace(*problem);
      second.emplace(*problem);
    } catch (const InputError&) {
      ++refused;  // not on offer
      continue;
    }
    ++tried;
    std::minstd_rand random(static_cast<unsigned>(number + 1));  // the same in every run
    // What cannot take so many steps, for not all that is on offer is wise, is compared up to there.
    int last = steps;
    std::string reason;
    const auto run = [&](Simulation& sim, int until) {
      try {
        while (sim.step_count() < until) sim.step();
        return true;
      } catch (const SolverError& error) {
        last = static_cast<int>(sim.step_count()) - 1;
        reason = error.what();
        return false;
      }
    };
    set_thread_count(1);
    if (!run(*whole, steps)) {
      whole.emplace(*problem);
      if (last >= 2) run(*whole, last);
    }
    if (last < 2) {
      failed.push_back(choice.name() + reason);
      continue;
    }
    Simulation first(*problem);
    const int when = 1 + static_cast<int>(random() % static_cast<unsigned>(last - 1));
    run(first, when);
    const StateTable saved = first.save_state();
    set_thread_count(2 + static_cast<int>(random() % 2));
    second->load_state(saved);
    run(*second, last);
    EXPECT_EQ(difference_of(whole->save_state(), second->save_state()), "") << choice.name() << "saved after step " << when << "\n" << text;
    set_thread_count(0);
  }
  fmt::print("{} combinations, every {}th: {} tried, {} not on offer, {} that fail at once\n", count, every, tried, refused, failed.size());
  EXPECT_GT(tried, 0);
  EXPECT_LE(failed.size(), 1 + static_cast<std::size_t>(tried) / share_to_fail) << fmt::format("{}", fmt::join(failed, "\n"));
}

TEST(Combinations, explicit_ones_continue_with_the_same_bits) {
  const auto materials = laws();
  continue_each(60, 50, [&](Choice& choice) {
    const std::string material = choice.of_names(materials);
    const std::string shape = choice.of_names({"linear", "bspline2", "bspline3", "gimp", "cpdi"});
    const std::string order = choice.of_names({"usl", "usf", "musl"});
    const std::string transfer = choice.of_names({"flip", "pic", "apic", "tpic", "fmpm"});
    const std::string contact = choice.of_names({"single_field", "multi_field", "pairs"});
    const std::string formulation = choice.of_names({"updated", "total"});
    const std::string precision = choice.of_names({"double", "single"});
    const int dim = choice.of_names({"2", "3"}) == "2" ? 2 : 3;
    // What else a case may have is not combined with all, but with many.
    const long more = static_cast<long>(std::hash<std::string>{}(choice.name()));
    const auto is_drawn = [&](int of, int which) { return std::abs(more) / 7 % of == which; };
    std::string text = (is_drawn(5, 1) ? "periodic = [\"x\"]\n" : "") + top(dim, 8) + "[time]\nend = 1\n[solver]\n";
    text += fmt::format("stress_order = \"{}\"\nshape = \"{}\"\ntransfer = \"{}\"\ncontact = \"{}\"\nprecision = \"{}\"\n", order, shape,
                        transfer, contact, precision);
    if (contact != "single_field") text += "friction = 0.3\n";
    const std::string body =
        fmt::format("formulation = \"{}\"\nlayout = {{ type = \"per_cell\", count = {} }}\n", formulation, dim == 2 ? 4 : 8);
    text += "[[body]]\nname = \"one\"\n" + box(dim, 0.2, 0.5, 0.3) + body + velocity(dim, 0.5, -0.2) + "material = " + material + "\n";
    if (is_drawn(7, 2)) text += "fbar = true\n";
    // A total Lagrangian body in one field is alone.
    if (formulation == "updated" || contact != "single_field")
      text += "[[body]]\nname = \"two\"\n" + box(dim, 0.52, 0.8, 0.4) + body + velocity(dim, -0.5, 0) + "material = " + rubber;
    const std::vector<std::string> floors{"kind = \"fixed\"\n", "kind = \"slip\"\ncontact = \"no_tension\"\n",
                                          "kind = \"fixed\"\ncontact = \"friction\"\nfriction = 0.2\n"};
    text += floor_of(dim) + floors[is_drawn(3, 0) ? 0 : is_drawn(3, 1) ? 1 : 2];
    return text + (is_drawn(4, 3) ? "[output]\nfields = [\"displacement\"]\n" : "");
  });
}

TEST(Combinations, implicit_ones_continue_with_the_same_bits) {
  const auto materials = laws();
  continue_each(6, 5, [&](Choice& choice) {
    const std::string material = choice.of_names(materials);
    const std::string basis =
        choice.of_names({"basis = \"bspline\"\n", "basis = \"element\"\nelement_order = 1\n", "basis = \"element\"\n"});
    const std::string mode = choice.of_names({"dynamic", "static"});
    const std::string contact = choice.of_names({"single_field", "pairs"});
    const std::string friction = "kind = \"fixed\"\ncontact = \"friction\"\nfriction = 0.3\n";
    const std::string side = choice.of_names(
        {"kind = \"fixed\"\n", "kind = \"slip\"\ncontact = \"no_tension\"\n", friction, friction + "contact_by = \"particles\"\n"});
    const std::string second = choice.of_names({"none", "particles", "elements"});
    const std::string fbar = choice.of_names({"", "fbar = true\n", "fbar = false\n"});
    const std::string steps =
        choice.of_names({"dt = 0.002\n", "rule = { type = \"newton_count\", first = 0.001, smallest = 1e-5, largest = 0.01 }\n"});
    const int dim = choice.of_names({"2", "3"}) == "2" ? 2 : 3;
    const std::string layout = fmt::format("layout = {{ type = \"per_cell\", count = {} }}\n", dim == 2 ? 4 : 8);
    std::string text = top(dim, dim == 2 ? 8 : 4) + "[time]\nend = 1\n" + steps + "[solver]\ntype = \"implicit\"\n" + basis;
    text += fmt::format("mode = \"{}\"\ncontact = \"{}\"\n", mode, contact);
    text += "[[body]]\nname = \"one\"\n" + box(dim, 0.25, 0.5, 0.25) + layout + fbar + "material = " + material + "\n";
    if (mode == "dynamic") text += velocity(dim, 0.5, -0.2);
    if (second != "none")
      text += "[[body]]\nname = \"two\"\n" + box(dim, 0.5, 0.75, 0.25) + (second == "particles" ? layout : "method = \"elements\"\n") +
              "material = " + rubber;
    return text + floor_of(dim) + side;
  });
}

}  // namespace
}  // namespace matpoint::test
