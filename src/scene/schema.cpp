#include "scene/schema.hpp"

#include <algorithm>

#include "scene/events.hpp"
#include "scene/flexible.hpp"
#include "scene/joints.hpp"
#include "scene/outlets.hpp"
#include "scene/probes.hpp"
#include "scene/settings.hpp"

namespace unibody {

namespace {

Json of_type(const char* type) { return Json::object().set("type", type); }

Json three_numbers(const char* about) {
  return of_type("array").set("items", of_type("number")).set("minItems", 3).set("maxItems", 3).set("description", about);
}

Json texts(const std::vector<std::string>& list) {
  Json result = Json::array();
  for (const std::string& text : list) result.push(text);
  return result;
}

// A map with these keys and no others, whatever they hold.
Json map_of(const std::vector<std::string>& keys, const std::vector<std::string>& required) {
  Json properties = Json::object();
  for (const std::string& key : keys) properties.set(key, true);
  Json map = of_type("object").set("additionalProperties", false).set("properties", properties);
  return required.empty() ? map : map.set("required", texts(required));
}

Json list_of(const Json& entry, const char* about) {
  return of_type("array").set("items", entry).set("minItems", 1).set("description", about);
}

// Which keys there may be depends on the type.
Json joint() {
  std::vector<std::string> all, types(joint_names.begin(), joint_names.end());
  Json by_type = Json::array();
  for (std::size_t kind = 0; kind < types.size(); ++kind) {
    const std::vector<std::string> keys = joint_entry_keys(static_cast<JointKind>(kind));
    for (const std::string& key : keys)
      if (std::ranges::find(all, key) == all.end()) all.push_back(key);
    const Json is = Json::object().set("properties", Json::object().set("type", Json::object().set("const", types[kind])));
    const Json then = Json::object().set("propertyNames", Json::object().set("enum", texts(keys)));
    by_type.push(Json::object().set("if", is).set("then", then));
  }
  Json entry = map_of(all, {"type", "bodies"});
  return entry.set("allOf", by_type);
}

// A number, or values in time.
Json in_time(const char* about) {
  return Json::object()
      .set("description", about)
      .set("anyOf", Json::array().push(settings::schema_of(not_negative)).push(of_type("array")).push(of_type("object")));
}

Json at_least_0(const char* about) { return settings::schema_of(not_negative).set("description", about); }

Json of_materials(bool pair) {
  Json properties = Json::object();
  if (pair) properties.set("between", of_type("array").set("items", of_type("string")).set("minItems", 2).set("maxItems", 2));
  properties.set("friction", in_time("Coulomb's coefficient, or values of it in time"))
      .set("restitution", settings::schema_of(Range{0, 1}).set("description", "speed after an impact over that before it"))
      .set("rolling_friction", at_least_0("resistance to rolling (m)"))
      .set("spinning_friction", at_least_0("resistance to spinning (m)"));
  return of_type("object")
      .set("additionalProperties", false)
      .set("properties", properties)
      .set("required", Json::array().push(pair ? "between" : "friction"));
}

Json materials() {
  return of_type("object")
      .set("properties", Json::object().set("pairs", of_type("array").set("items", of_materials(true)).set("minItems", 1)))
      .set("additionalProperties", of_materials(false));
}

}  // namespace

std::string scene_schema() {
  Json properties = Json::object();
  properties.set("title", of_type("string").set("description", "stands in the report"))
      .set("time", schema_of(time_settings()))
      .set("planar", of_type("boolean").set("description", "motion in x and z and turns about y only"))
      .set("gravity",
           Json::object()
               .set("description", "m/s^2; three numbers or values in time, or a table")
               .set("anyOf", Json::array().push(of_type("array").set("minItems", 3).set("maxItems", 3)).push(of_type("object"))))
      .set("wind", three_numbers("velocity of the air (m/s)"))
      .set("air_density", at_least_0("kg/m^3"))
      .set("solver", schema_of(solver_settings()))
      .set("output", schema_of(output_settings()))
      .set("materials", materials())
      .set("bodies", list_of(map_of(body_keys(), {}), "bodies, and generators of bodies"))
      .set("cloths", list_of(map_of(cloth_keys(), {"thickness"}), "cloths"))
      .set("threads", list_of(map_of(thread_keys(), {"points", "segments"}), "threads"))
      .set("solids", list_of(map_of(solid_keys(), {"thickness"}), "soft solids"))
      .set("joints", list_of(joint(), "joints between bodies"))
      .set("probes", list_of(map_of(probe_keys(), {"name"}), "what report.csv measures beside its usual columns"))
      .set("outlets", list_of(map_of(outlet_keys(), {"name", "box"}), "boxes in which bodies leave the scene"))
      .set("events",
           list_of(map_of(event_keys(), {"do", "when"}), "what happens at a time, or when something else has happened"));
  return Json::object()
             .set("$schema", "http://json-schema.org/draft-07/schema#")
             .set("title", "A scene of Unibody")
             .set("type", "object")
             .set("additionalProperties", false)
             .set("properties", properties)
             .text() +
         "\n";
}

}  // namespace unibody
