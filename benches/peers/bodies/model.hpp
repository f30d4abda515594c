// Pinocchio's model of a table that bodies.py writes, a line for each body: joint (free, ball, y or z), place in the body before, mass, mass centre,
// moments of inertia about it.
#pragma once
#include <fstream>
#include <pinocchio/multibody.hpp>
#include <string>

namespace pin = pinocchio;

inline pin::Model model_of(const std::string& name) {
  pin::Model bodies;
  bodies.gravity.linear() = Eigen::Vector3d(0, 0, -9.81);
  std::ifstream table(name);
  pin::JointIndex parent = 0;
  std::string kind;
  double mass;
  Eigen::Vector3d place, centre, moments;
  auto read = [&](Eigen::Vector3d& v) { table >> v[0] >> v[1] >> v[2]; };
  while (table >> kind) {
    read(place);
    table >> mass;
    read(centre);
    read(moments);
    const pin::SE3 at(Eigen::Matrix3d::Identity(), place);
    const std::string joint = "joint" + std::to_string(bodies.njoints);
    if (kind == "free") parent = bodies.addJoint(parent, pin::JointModelFreeFlyer(), at, joint);
    else if (kind == "ball") parent = bodies.addJoint(parent, pin::JointModelSpherical(), at, joint);
    else if (kind == "y") parent = bodies.addJoint(parent, pin::JointModelRY(), at, joint);
    else parent = bodies.addJoint(parent, pin::JointModelRZ(), at, joint);
    bodies.appendBodyToJoint(parent, pin::Inertia(mass, centre, Eigen::Matrix3d(moments.asDiagonal())), pin::SE3::Identity());
  }
  return bodies;
}
