#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/text.hpp"
#include "meshes/mesh_file.hpp"
#include "scene/mjcf_elements.hpp"

namespace unibody {

namespace {

using pugi::xml_node;

// Elements that make no difference to motion.
const std::vector<std::string_view> pictures{"site",   "camera",    "light",  "texture", "material", "skin",
                                             "visual", "statistic", "sensor", "custom",  "size"};

// The format of MuJoCo. Its angles and offsets are `ref` where the bodies are as they are written; here they are then 0.
class MjcfReader {
 public:
  explicit MjcfReader(const std::string& path) : elements_(path) {}

  RobotModel read() {
    compiler_ = read_compiler(elements_);
    elements_.read_defaults();
    for (const xml_node& section : elements_.sections("asset")) read_meshes(section);
    model_.root_is_world = true;
    model_.links.emplace_back().name = "world";
    const std::vector<xml_node> worlds = elements_.sections("worldbody");
    for (const xml_node& world : worlds) read_children(world, 0, {}, "");
    if (model_.links.size() == 1 && model_.links[0].shapes.empty())
      elements_.fail(worlds.empty() ? elements_.root() : worlds[0], "no body in <worldbody>", "one");
    for (const xml_node& section : elements_.sections("equality"))
      elements_.for_each_child(section, [&](const xml_node& node) { read_equality(node); });
    for (const xml_node& section : elements_.sections("actuator"))
      elements_.for_each_child(section, [&](const xml_node& node) { read_actuator(node); });
    for (const char* name : {"option", "contact", "tendon", "keyframe", "deformable", "extension"})
      for (const xml_node& section : elements_.sections(name)) {
        if (std::string_view(name) == "option") ++elements_.unused[name];
        elements_.for_each_child(section,
                                 [&](const xml_node& node) { ++elements_.unused[std::string(name) + " " + node.name()]; });
      }
    for (const auto& [name, count] : elements_.unused)
      model_.unused += (model_.unused.empty() ? "" : ", ") + name + " (" + std::to_string(count) + ")";
    return std::move(model_);
  }

 private:
  struct Mesh {
    std::string file;
    Vec3 scale = Vec3::Ones();
    std::vector<Vec3> points;
  };
  // What hangs on a body: its joints, and whether it says its mass.
  struct Found {
    std::vector<std::pair<MjcfElement, Pose>> joints;  // and the frames in which they stand
    bool is_free = false;
  };

  void read_meshes(const xml_node& section) {
    elements_.for_each_child(section, [&](const xml_node& node) {
      const std::string kind = node.name();
      if (kind != "mesh") {
        if (std::ranges::find(pictures, kind) == pictures.end()) ++elements_.unused["asset " + kind];
        return;
      }
      const MjcfElement of(elements_, node, "",
                           {"file", "scale", "vertex", "face", "normal", "texcoord", "smoothnormal", "content_type"});
      Mesh mesh;
      mesh.scale = of.vector("scale", Vec3::Ones());
      if (of.has("vertex")) {
        const std::vector<double> x = of.numbers("vertex", 12, 3'000'000);
        if (x.size() % 3 != 0) of.fail("vertex", "three numbers a vertex");
        for (std::size_t k = 0; k < x.size(); k += 3)
          mesh.points.push_back(Vec3(x[k], x[k + 1], x[k + 2]).cwiseProduct(mesh.scale));
      } else {
        const std::filesystem::path file = elements_.file_of(node).text(node, "file");
        mesh.file = (std::filesystem::path(compiler_.mesh_folder) / file).string();
      }
      const std::string name = of.text("name", std::filesystem::path(mesh.file).stem().string());
      if (!meshes_.try_emplace(name, std::move(mesh)).second)
        elements_.fail(node, "a second mesh " + quote(name), "another name");
    });
  }

  static std::string first_free(const std::string& wish, const auto& list) {
    std::string name = wish;
    const auto is_taken = [&](const auto& each) { return each.name == name; };
    for (int k = 2; std::ranges::any_of(list, is_taken); ++k) name = wish + "_" + std::to_string(k);
    return name;
  }

  std::size_t add_link(const std::string& name, const xml_node& node) {
    RobotLink& link = model_.links.emplace_back();
    link.name = name, link.line = elements_.file_of(node).line_of(node);
    return model_.links.size() - 1;
  }

  void read_body(const xml_node& node, std::size_t parent, const Pose& frame, const std::string& child_class) {
    const MjcfElement of(elements_, node, "", {"pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "childclass"});
    const std::string said = of.text("name", "");
    if (!said.empty() && std::ranges::find(model_.links, said, &RobotLink::name) != model_.links.end())
      elements_.fail(node, "a second body " + quote(said), "another name");
    const std::size_t link =
        add_link(said.empty() ? first_free("body" + std::to_string(model_.links.size()), model_.links) : said, node);
    // The joints lead to it, so that they come before what hangs on it: what the body itself has is read first.
    const std::string own_class = of.text("childclass", child_class);
    const std::size_t first_joint = model_.joints.size();
    add_joints(node, link, parent, frame * compiler_.pose(of), own_class);
    read_children(node, link, {}, own_class);
    const bool is_free = model_.joints[first_joint].kind == RobotJoint::Kind::floating;
    if (is_free && parent != 0) elements_.fail(node, "a free joint in a body of another", "one in a body of the world");
  }

  void gather_joints(const xml_node& node, const Pose& frame, const std::string& child_class, Found& found) {
    elements_.for_each_child(node, [&](const xml_node& child) {
      const std::string_view kind = child.name();
      if (kind == "frame") {
        const MjcfElement of(elements_, child, "", {"pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "childclass"});
        gather_joints(child, frame * compiler_.pose(of), of.text("childclass", child_class), found);
      } else if (kind == "freejoint") {
        found.is_free = true;
      } else if (kind == "joint") {
        const MjcfElement of(
            elements_, child, child_class,
            {"type", "pos", "axis", "range", "limited", "damping", "frictionloss", "stiffness", "springref", "ref", "group"});
        if (of.text("type", "hinge") == "free")
          found.is_free = true;
        else
          found.joints.emplace_back(of, frame);
      }
    });
  }

  // The joints between a body and its parent. Between two of them is a link of its own, which stands where the body does.
  void add_joints(const xml_node& body, std::size_t link, std::size_t parent, Pose pose, const std::string& child_class) {
    Found found;
    gather_joints(body, {}, child_class, found);
    const std::string name = model_.links[link].name;
    if (found.joints.empty() || found.is_free) {
      if (!found.joints.empty()) elements_.fail(body, "a body with a free joint and others", "the free joint alone");
      RobotJoint joint;
      joint.name = first_free(name + "_joint", model_.joints), joint.line = model_.links[link].line;
      joint.kind = found.is_free ? RobotJoint::Kind::floating : RobotJoint::Kind::fixed;
      joint.parent = parent, joint.child = link, joint.pose = pose;
      model_.joints.push_back(joint);
      return;
    }
    for (std::size_t k = 0; k < found.joints.size(); ++k) {
      RobotJoint joint = read_joint(found.joints[k].first, found.joints[k].second, name);
      joint.parent = parent, joint.pose = pose, joint.child = link;
      if (k + 1 < found.joints.size()) {
        joint.child = add_link(first_free(name + "_" + std::to_string(k + 1), model_.links), found.joints[k].first.node());
        model_.links.back().between_joints_of = static_cast<std::int64_t>(link);
        parent = joint.child, pose = {};
      }
      model_.joints.push_back(std::move(joint));
    }
    if (found.joints.size() > 1)
      model_.notes.push_back(
          "body " + name + " has " + std::to_string(found.joints.size()) +
          " joints: of its mass 1 % goes with each link between two of them; solver.joints: direct solves them to "
          "rounding");
  }

  RobotJoint read_joint(const MjcfElement& of, const Pose& frame, const std::string& body) {
    using Kind = RobotJoint::Kind;
    RobotJoint joint;
    const std::string said = of.text("name", "");
    if (!said.empty() && std::ranges::find(model_.joints, said, &RobotJoint::name) != model_.joints.end())
      elements_.fail(of.node(), "a second joint " + quote(said), "another name");
    joint.name = said.empty() ? first_free(body + "_joint", model_.joints) : said;
    joint.line = elements_.file_of(of.node()).line_of(of.node());
    const std::string type = of.text("type", "hinge");
    if (type != "hinge" && type != "slide" && type != "ball") of.fail("type", "free, ball, slide or hinge");
    joint.kind = type == "hinge" ? Kind::revolute : type == "slide" ? Kind::prismatic : Kind::ball;
    joint.anchor = frame * of.vector("pos", Vec3::Zero());
    const Vec3 axis = of.vector("axis", Vec3::UnitZ());
    if (!(axis.norm() > 0)) of.fail("axis", "a vector that is not 0");
    joint.axis = (frame.turn * axis).normalized();
    const auto not_negative = [&](const char* name) {
      const double value = of.number(name, 0);
      if (!(value >= 0)) of.fail(name, "a number >= 0");
      return value;
    };
    const double unit = type == "hinge" ? compiler_.angle : 1, ref = unit * of.number("ref", 0);
    const bool is_limited = of.flag("limited", compiler_.auto_limits && of.has("range"));
    joint.friction = not_negative("frictionloss"), joint.damping = not_negative("damping");
    joint.stiffness = not_negative("stiffness");
    if (joint.kind == Kind::ball) {
      for (const auto& [name, is_there] :
           {std::pair("range", is_limited), std::pair("damping", joint.damping > 0), std::pair("stiffness", joint.stiffness > 0),
            std::pair("frictionloss", joint.friction > 0)})
        if (is_there) ++elements_.unused[std::string(name) + " of a ball joint"];
      joint.friction = joint.damping = joint.stiffness = 0;
      return joint;
    }
    if (joint.stiffness > 0) joint.rest = unit * of.number("springref", 0) - ref;
    reference_[joint.name] = ref;
    if (is_limited) {
      const std::vector<double> range = of.numbers("range", 2, 2);
      if (range[0] > range[1]) of.fail("range", "the lower limit first");
      joint.lower = unit * range[0] - ref, joint.upper = unit * range[1] - ref;
    }
    return joint;
  }

  // Shapes, mass and bodies in a body or in the world. `frame`: of a <frame> in that of the link.
  void read_children(const xml_node& node, std::size_t link, const Pose& frame, const std::string& child_class) {
    elements_.for_each_child(node, [&](const xml_node& child) {
      const std::string kind = child.name();
      if (kind == "geom") {
        read_geom(child, link, frame, child_class);
      } else if (kind == "inertial") {
        read_inertial(child, link, frame);
      } else if (kind == "body") {
        read_body(child, link, frame, child_class);
      } else if (kind == "frame") {
        const MjcfElement of(elements_, child, "", {"pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "childclass"});
        read_children(child, link, frame * compiler_.pose(of), of.text("childclass", child_class));
      } else if (kind != "joint" && kind != "freejoint" && std::ranges::find(pictures, kind) == pictures.end()) {
        ++elements_.unused[kind];
      }
    });
    if (model_.links[link].mass > 0)  // its <inertial> says it all
      for (RobotShape& shape : model_.links[link].shapes) shape.mass = shape.density = 0;
  }

  void read_inertial(const xml_node& node, std::size_t link, const Pose& frame) {
    const MjcfElement of(elements_, node, "",
                         {"pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "mass", "diaginertia", "fullinertia"});
    if (compiler_.shapes_give_mass) return;
    RobotLink& own = model_.links[link];
    own.centre = frame * compiler_.pose(of);
    own.mass = of.numbers("mass", 1, 1)[0];
    if (!(own.mass > 0)) of.fail("mass", "a number > 0");
    if (of.has("fullinertia")) {
      const std::vector<double> m = of.numbers("fullinertia", 6, 6);
      own.inertia << m[0], m[3], m[4], m[3], m[1], m[5], m[4], m[5], m[2];
    } else {
      if (!of.has("diaginertia")) elements_.fail(node, "<inertial> without diaginertia and fullinertia", "one of the two");
      own.inertia = of.vector("diaginertia", Vec3::Zero()).asDiagonal();
    }
    if (!(Eigen::SelfAdjointEigenSolver<Mat3>(own.inertia, Eigen::EigenvaluesOnly).eigenvalues().minCoeff() > 0))
      elements_.fail(node, "moments of inertia that are not all > 0 about their principal axes", "those of a solid");
  }

  void read_geom(const xml_node& node, std::size_t link, const Pose& frame, const std::string& child_class) {
    const MjcfElement of(elements_, node, child_class,
                         {"type", "size", "fromto", "pos", "quat", "axisangle", "xyaxes", "zaxis", "euler", "mesh", "mass",
                          "density", "contype", "conaffinity", "group", "rgba", "material"});
    const std::string type = of.text("type", "sphere");
    if (link == 0 && (type == "plane" || type == "hfield")) {
      ++elements_.unused[type + " of the world"];
      return;
    }
    RobotShape shape;
    shape.line = elements_.file_of(node).line_of(node);
    shape.pose = compiler_.pose(of);
    shape.density = link == 0 ? 0 : of.number("density", 1000), shape.mass = link == 0 ? 0 : of.number("mass", 0);
    if (!(shape.mass >= 0)) of.fail("mass", "a number >= 0");
    if (!(shape.density >= 0)) of.fail("density", "a number >= 0");
    if (of.has("mass") && shape.mass == 0) shape.density = 0;
    const double touches = of.number("contype", 1), touched = of.number("conaffinity", 1);
    shape.touches = touches != 0 || touched != 0;
    for (const auto& [name, bits] : {std::pair("geom contype", touches), std::pair("geom conaffinity", touched)})
      if (bits > 1) ++elements_.unused[name];
    set_size(of, type, shape);
    shape.pose = frame * shape.pose;
    model_.links[link].shapes.push_back(std::move(shape));
  }

  void set_size(const MjcfElement& of, const std::string& type, RobotShape& shape) const {
    using Kind = RobotShape::Kind;
    static const std::vector<std::string> types{"sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh"};
    if (std::ranges::find(types, type) == types.end()) of.fail("type", one_of(types));
    if (type == "mesh") {
      const auto mesh = meshes_.find(of.text("mesh", ""));
      if (mesh == meshes_.end()) of.fail("mesh", "the name of a mesh of <asset>");
      shape.kind = mesh->second.file.empty() ? Kind::points : Kind::mesh;
      shape.file = mesh->second.file.empty() ? mesh->first : mesh->second.file;
      shape.size = mesh->second.scale, shape.points = mesh->second.points;
      return;
    }
    if (of.has("mesh")) of.fail("mesh", "type mesh with it");
    std::vector<double> size = of.numbers("size", 1, 3);
    if (of.has("fromto")) {
      if (type == "sphere") of.fail("fromto", "none of a sphere");
      const std::vector<double> ends = of.numbers("fromto", 6, 6);
      const Vec3 from(ends[0], ends[1], ends[2]), to(ends[3], ends[4], ends[5]);
      if (!((to - from).norm() > 0)) of.fail("fromto", "two places apart");
      shape.pose = {0.5 * (from + to), Quat::FromTwoVectors(Vec3::UnitZ(), from - to)};  // along the negative z axis
      size = type == "capsule" || type == "cylinder" ? std::vector{size[0], 0.0} : std::vector{size[0], size[0], 0.0};
      size.back() = 0.5 * (to - from).norm();
    }
    const std::size_t count = type == "sphere" ? 1 : type == "capsule" || type == "cylinder" ? 2 : 3;
    if (size.size() < count ||
        !std::all_of(size.begin(), size.begin() + static_cast<std::ptrdiff_t>(count), [](double x) { return x > 0; }))
      of.fail("size", count == 1 ? "a number > 0" : std::to_string(count) + " numbers > 0");
    if (type == "sphere") shape.kind = Kind::sphere, shape.size = {size[0], 0, 0};
    if (type == "capsule") shape.kind = Kind::capsule, shape.size = {size[0], 2 * size[1], 0};
    if (type == "cylinder") shape.kind = Kind::cylinder, shape.size = {size[0], 2 * size[1], 0};
    if (type == "box") shape.kind = Kind::box, shape.size = 2 * Vec3(size[0], size[1], size[2]);
    if (type == "ellipsoid") make_ellipsoid({size[0], size[1], size[2]}, shape);
  }

  // The hull of points on it, with the mass of the whole.
  static void make_ellipsoid(const Vec3& half, RobotShape& shape) {
    constexpr int around = 24, across = 12;
    shape.kind = RobotShape::Kind::points, shape.file = "ellipsoid";
    for (int i = 0; i <= across; ++i)
      for (int k = 0; k < (i % across == 0 ? 1 : around); ++k) {
        const double polar = M_PI * i / across, turn = 2 * M_PI * k / around;
        const Vec3 x(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar));
        shape.points.push_back(x.cwiseProduct(half));
      }
    if (shape.mass == 0) shape.mass = shape.density * 4 * M_PI / 3 * half.prod();
  }

  std::size_t link_of(const MjcfElement& of, const char* name) const {
    const std::string said = of.text(name, "world");
    const auto found = std::ranges::find(model_.links, said, &RobotLink::name);
    if (found == model_.links.end()) of.fail(name, "the name of a body");
    return static_cast<std::size_t>(found - model_.links.begin());
  }
  RobotJoint& joint_of(const MjcfElement& of, const char* name) {
    const auto found = std::ranges::find(model_.joints, of.text(name, ""), &RobotJoint::name);
    if (found == model_.joints.end() || !found->has_coordinate() || found->mimic)
      of.fail(name, "the name of a hinge or slide joint that goes with no other");
    return *found;
  }

  void read_equality(const xml_node& node) {
    const std::string kind = node.name();
    const MjcfElement of(elements_, node, "", {"body1", "body2", "anchor", "joint1", "joint2", "polycoef", "active"});
    const std::vector<double> c = of.has("polycoef") ? of.numbers("polycoef", 1, 5) : std::vector<double>{0, 1};
    const bool is_linear = c.size() > 1 && c[1] != 0 && std::all_of(c.begin() + 2, c.end(), [](double x) { return x == 0; });
    if (!of.flag("active", true) || (kind == "joint" ? !of.has("joint2") || !is_linear : !of.has("body1"))) {
      ++elements_.unused["equality " + kind + (of.flag("active", true) ? " of another form" : " that is not active")];
    } else if (kind == "joint") {
      RobotJoint &own = joint_of(of, "joint1"), &other = joint_of(of, "joint2");
      const auto goes_with_own = [&](const RobotJoint& joint) { return joint.mimic && joint.mimic->joint == own.name; };
      if (&own == &other || std::ranges::any_of(model_.joints, goes_with_own))
        of.fail("joint2", "a joint that goes with no other");
      own.mimic = RobotMimic{other.name, c[1], c[0]};
    } else if (kind == "connect" || kind == "weld") {
      RobotLoop loop;
      loop.kind = kind == "weld" ? JointKind::fixed : JointKind::ball;
      loop.name = of.text("name", first_free(kind, model_.loops));
      loop.links = {link_of(of, "body1"), link_of(of, "body2")};
      loop.anchor = of.vector("anchor", Vec3::Zero());
      model_.loops.push_back(std::move(loop));
    } else {
      ++elements_.unused["equality " + kind];
    }
  }

  // A motor that holds a joint at 0, or at rest, with at most the force that the file names.
  void read_actuator(const xml_node& node) {
    const std::string kind = node.name();
    const MjcfElement of(elements_, node, "",
                         {"joint", "forcerange", "forcelimited", "gear", "kp", "kv", "ctrlrange", "ctrllimited", "inheritrange",
                          "group", "dampratio"});
    const bool is_motor = (kind == "position" || kind == "velocity") && of.has("joint");
    if (!is_motor || !of.flag("forcelimited", compiler_.auto_limits && of.has("forcerange"))) {
      ++elements_.unused["actuator " + kind + (is_motor ? " without forcerange" : "")];
      return;
    }
    RobotJoint& joint = joint_of(of, "joint");
    const std::vector<double> range = of.numbers("forcerange", 2, 2);
    const double gear = of.has("gear") ? of.numbers("gear", 1, 6)[0] : 1;
    joint.motor = kind == "position" ? Motor::position : Motor::speed;
    joint.strength = std::abs(gear) * std::max(std::abs(range[0]), std::abs(range[1]));
    joint.target = kind == "position" ? -reference_[joint.name] : 0;
  }

  MjcfElements elements_;
  MjcfCompiler compiler_;
  RobotModel model_;
  std::map<std::string, Mesh> meshes_;
  std::map<std::string, double> reference_;  // of each joint, rad or m
};

}  // namespace

RobotModel read_mjcf(const std::string& path) { return MjcfReader(path).read(); }

}  // namespace unibody
