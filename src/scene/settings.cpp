#include "scene/settings.hpp"

#include <algorithm>
#include <charconv>
#include <stdexcept>

#include "core/text.hpp"

namespace unibody {

namespace settings {

std::string text_of(double x) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), x).ptr};
}

Json json_of(const std::string& text) {
  double x = 0;
  const char* end = text.data() + text.size();
  if (const auto [last, error] = std::from_chars(text.data(), end, x); error == std::errc() && last == end) return x;
  if (text == "true" || text == "false") return text == "true";
  return text;
}

Json schema_of(const Range& range) {
  Json schema = Json::object().set("type", "number");
  if (range.low > -1e308) schema.set(range.low_open ? "exclusiveMinimum" : "minimum", range.low);
  if (range.high < 1e308) schema.set(range.high_open ? "exclusiveMaximum" : "maximum", range.high);
  return schema;
}

std::string words_of(const Range& range) {
  const std::string text = range.text();
  return text.empty() ? "number" : "number" + text;
}

std::optional<double> read_number_or_auto(const Value& value, const Range& range, const std::string& unit) {
  if (value.kind == Value::Kind::scalar && !value.quoted && value.text == "auto") return std::nullopt;
  try {
    return value.number(range, unit);
  } catch (const std::runtime_error&) {
    value.fail_expected("auto or a number" + range.text() + (unit.empty() ? "" : " (" + unit + ")"));
  }
}

std::optional<std::int64_t> read_integer_or_auto(const Value& value, std::int64_t low, std::int64_t high) {
  if (value.kind == Value::Kind::scalar && !value.quoted && value.text == "auto") return std::nullopt;
  try {
    return value.integer(low, high);
  } catch (const std::runtime_error&) {
    value.fail_expected("auto or an integer >= " + std::to_string(low) + ", <= " + std::to_string(high));
  }
}

Json schema_of(std::int64_t low, std::int64_t high) {
  return Json::object().set("type", "integer").set("minimum", low).set("maximum", high);
}

std::string words_of(std::int64_t low, std::int64_t high) {
  return "integer >= " + std::to_string(low) + (high < std::int64_t{1} << 53 ? ", <= " + std::to_string(high) : "");
}

Json schema_of(const std::vector<std::string>& names) {
  Json list = Json::array();
  for (const std::string& name : names) list.push(name);
  return Json::object().set("enum", list);
}

std::string words_of(const std::vector<std::string>& names) { return one_of(names); }

}  // namespace settings

namespace {

using namespace settings;

// What is allowed depends on the level, which is known when all is read: only what no level bears is refused here.
Setting<SolverSettings> warm_start() {
  return {"warm_start",
          "",
          "auto, or number in [0, 0.5] (level: velocity [0, 1])",
          "share of the old multipliers from which the position stage starts",
          [](const Value& v, SolverSettings& s) {
            s.warm_start = read_number_or_auto(v, any_number, "");
            if (s.warm_start && !(*s.warm_start >= 0)) v.fail_expected(position_shares);
          },
          [](const SolverSettings& s) { return s.warm_start ? settings::text_of(*s.warm_start) : "auto"; },
          [] {
            return or_auto(settings::schema_of(Range{0, 1}));
          }};
}

std::vector<std::string> accuracy_names() {
  std::vector<std::string> names{"auto"};
  for (const NamedAccuracy& named : named_accuracies) names.emplace_back(named.name);
  return names;
}

Setting<SolverSettings> accuracy() {
  const Range shares{0, 1, true};
  const std::string words = "auto, film (1e-2), engineering (1e-3), reference (1e-5), or number" + shares.text();
  return {"accuracy",
          "",
          words,
          "share of the smallest moving body's size by which a frame may be off: the program then picks the iterations",
          [=](const Value& v, SolverSettings& s) {
            const bool word = v.kind == Value::Kind::scalar && !v.quoted;
            const auto named = std::ranges::find(named_accuracies, std::string_view(v.text), &NamedAccuracy::name);
            if (word && named != named_accuracies.end()) return void(s.accuracy = named->share);
            try {
              s.accuracy = read_number_or_auto(v, shares, "");
            } catch (const std::runtime_error&) {
              v.fail_expected(words);
            }
          },
          [](const SolverSettings& s) { return s.accuracy ? settings::text_of(*s.accuracy) : "auto"; },
          [=] {
            const Json alternatives = Json::array().push(settings::schema_of(shares)).push(settings::schema_of(accuracy_names()));
            return Json::object().set("anyOf", alternatives);
          }};
}

Setting<SolverSettings> solver_name() {
  return {"name",
          "",
          words_of(solver_names()),
          "solver; newton is a reference for one flexible body alone",
          [](const Value& v, SolverSettings& s) { s.name = solver_names()[v.choice(solver_names())]; },
          [](const SolverSettings& s) { return s.name; },
          [] { return settings::schema_of(solver_names()); }};
}

Setting<OutputSettings> precision() {
  const std::vector<std::string> names{"single", "double"};
  return {"precision",
          "",
          words_of(names),
          "of the written frames; checkpoints are always double",
          [=](const Value& v, OutputSettings& o) { o.single_precision = v.choice(names) == 0; },
          [](const OutputSettings& o) { return o.single_precision ? "single" : "double"; },
          [=] { return settings::schema_of(names); }};
}

}  // namespace

const SettingList<TimeSettings>& time_settings() {
  using T = TimeSettings;
  static const SettingList<T> list{
      number("frame", "s", positive, &T::frame, "length of a frame"),
      integer("frames", "", 0, std::int64_t{1} << 53, &T::frames, "frames to run"),
      integer("substeps", "", 1, 1'000'000, &T::substeps, "steps of equal length in a frame"),
  };
  return list;
}

const SettingList<OutputSettings>& output_settings() {
  using T = OutputSettings;
  static const SettingList<T> list{
      integer("every", "frames", 0, 1'000'000'000, &T::every, "frames from one written frame to the next; 0: none is written"),
      flag("crossings", &T::crossings, "count in every frame the edges of cloths and threads that go through faces of cloths"),
      flag("joints", &T::joints, "write what each joint does, in the frames that are written"),
      integer("contacts", "frames", 0, 1'000'000'000, &T::contacts,
              "frames from one to the next whose contacts and forces are written; 0: none"),
      integer("checkpoint_every", "frames", -1, 1'000'000'000, &T::checkpoint_every,
              "frames from one checkpoint to the next; 0: one at the end; -1: none"),
      number("checkpoint_minutes", "min", not_negative, &T::checkpoint_minutes,
             "wall time after which a frame is followed by a checkpoint, whatever checkpoint_every says; 0: no matter"),
      precision(),
  };
  return list;
}

const SettingList<SolverSettings>& solver_settings() {
  using T = SolverSettings;
  static const SettingList<T> list{
      solver_name(),
      integer_or_auto("iterations", "", 1, 1'000'000'000, &T::iterations,
                      "the most of a step, over both stages (two stages: >= 2)"),
      accuracy(),
      number_or_auto("tolerance", "m", not_negative, &T::tolerance, "natural residual at which a stage stops; 0: never"),
      choice("acceleration", acceleration_names, &T::acceleration,
             "how accelerated_jacobi and gauss_seidel extrapolate from sweep to sweep"),
      choice("mass_sharing", mass_sharing_names, &T::mass_sharing,
             "how the Jacobi solvers share a body's mass among constraints"),
      choice("level", level_names, &T::level, "velocity: the classic time stepping, for comparison"),
      number("stabilisation", "", {0, 1}, &T::stabilisation,
             "at velocity level alone: share of an error of position that a step takes out"),
      choice("stages", stages_names, &T::stages, "the stages of a step"),
      choice("form", form_names, &T::form, "of constraints beside contacts: what their multipliers are measured from"),
      warm_start(),
      number_or_auto("velocity_share", "", {0, 1, true, true}, &T::velocity_share,
                     "share of the iterations that the velocity stage does, of two"),
      number_or_auto("leak", "", {0, 1}, &T::leak,
                     "share of the position stage's multipliers that the next step's velocity stage is given"),
      choice("friction", friction_model_names, &T::friction, "model of friction"),
      choice("joints", joint_solve_names, &T::joints, "direct: the rows of a tree of joints are solved together"),
      flag("coarse", &T::coarse, "cloths, threads and solids that touch nothing are solved on two levels before the sweeps"),
      choice("gap", gap_names, &T::gap, "gaps of contacts: linear in the step, or found anew in every iteration"),
      choice("order", order_names, &T::order, "of gauss_seidel; sequential: on one rank only"),
      number("scaling", "", {0, 1, true}, &T::scaling, "factor on the constraint count of the Jacobi solvers"),
      number_or_auto("recovery_time", "s", not_negative, &T::recovery_time, "time constant at which penetration is taken out"),
      number_or_auto("recovery_speed", "m/s", not_negative, &T::recovery_speed,
                     "bound on the speed at which penetration is taken out; 0: none"),
      number_or_auto("margin", "m", not_negative, &T::margin,
                     "contacts are made at gaps below this plus what the bodies can travel in the step"),
  };
  return list;
}

std::string settings_table() {
  return "| key | unit | default | values | what it does |\n|---|---|---|---|---|\n" + rows_of(time_settings(), "time.") +
         rows_of(output_settings(), "output.") + rows_of(solver_settings(), "solver.");
}

}  // namespace unibody
