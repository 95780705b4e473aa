// Tight C++ on Pinocchio's library, to compare with: poses by Newton's method from home, whose first
// step is known once for all, J_eq by one factorisation of K*, and the singular values of its
// linear and angular rows. No step is certain, no pose is told to be singular: it is as little as
// one can do. Of redundant rows those that are independent at home are kept, which takes less time
// than a QR of all, or their normal equations.
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/multibody.hpp>
#include <pinocchio/serialization.hpp>

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <vector>

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Linear = Eigen::Matrix<double, 6, Eigen::Dynamic>;
using Columns = Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>>;
using Across = Eigen::Matrix<double, 3, 2>;

struct Loop
{
    int first, second, rows; // frames
    double rod;              // its length; 0 where two points are one
    Eigen::Vector3d axis;    // of a hinge, in either frame; 0 where there is none
    Across across;           // in the second frame
};

struct Peer
{
    pinocchio::Model model;
    pinocchio::Data data;
    std::vector<Loop> loops;
    std::vector<int> motors, passive, kept;
    int tool;
    Vector home, q, residual, kept_residual, step, rates;
    Matrix jacobian, K, K_star, follow, at_home; // the last two: K*⁻¹ K
    Linear one, other;
    Eigen::PartialPivLU<Matrix> lu;

    void evaluate()
    {
        pinocchio::computeJointJacobians(model, data, q);
        pinocchio::updateFramePlacements(model, data);
        int row = 0;
        for (const Loop & loop : loops) {
            const pinocchio::SE3 & first = data.oMf[loop.first], & second = data.oMf[loop.second];
            one.setZero(), other.setZero();
            getFrameJacobian(model, data, loop.first, pinocchio::LOCAL_WORLD_ALIGNED, one);
            getFrameJacobian(model, data, loop.second, pinocchio::LOCAL_WORLD_ALIGNED, other);
            one -= other;
            const Eigen::Vector3d gap = first.translation() - second.translation();
            if (loop.rod > 0.0) {
                residual[row] = 0.5 * (gap.squaredNorm() / loop.rod - loop.rod);
                jacobian.row(row) = gap.transpose() / loop.rod * one.topRows<3>();
            } else {
                residual.segment<3>(row) = gap;
                jacobian.middleRows<3>(row) = one.topRows<3>();
            }
            if (loop.rows == 5) {
                const Eigen::Vector3d axis = first.rotation() * loop.axis;
                const Across across = second.rotation() * loop.across;
                residual.segment<2>(row + 3) = across.transpose() * axis;
                for (int k = 0; k < 2; k++)
                    jacobian.row(row + 3 + k) =
                        axis.cross(across.col(k)).transpose() * one.bottomRows<3>();
            }
            row += loop.rows;
        }
    }

    void factorise()
    {
        const int count = kept.size();
        for (int row = 0; row < count; row++) {
            const auto of = jacobian.row(kept[row]);
            for (int k = 0; k < count; k++) K_star(row, k) = of[passive[k]];
            for (std::size_t k = 0; k < motors.size(); k++) K(row, k) = of[motors[k]];
        }
        lu.compute(K_star);
    }

    void move_passive()
    {
        for (std::size_t k = 0; k < passive.size(); k++) rates[passive[k]] = -step[k];
    }

    bool close(const Eigen::Map<const Vector> & displacement, double tolerance)
    {
        step = at_home * displacement;
        for (std::size_t k = 0; k < motors.size(); k++) rates[motors[k]] = displacement[k];
        move_passive();
        pinocchio::integrate(model, home, rates, q);
        rates.setZero();
        for (int tries = 0; tries < 20; tries++) {
            evaluate(), factorise();
            if (residual.norm() < tolerance) return true;
            for (std::size_t k = 0; k < kept.size(); k++) kept_residual[k] = residual[kept[k]];
            step = lu.solve(kept_residual);
            move_passive();
            q = pinocchio::integrate(model, q, rates);
        }
        return false;
    }

    void tool_jacobian(Columns found)
    {
        follow = lu.solve(K);
        one.setZero();
        getFrameJacobian(model, data, tool, pinocchio::LOCAL_WORLD_ALIGNED, one);
        for (std::size_t k = 0; k < motors.size(); k++) found.col(k) = one.col(motors[k]);
        for (std::size_t k = 0; k < passive.size(); k++)
            found -= one.col(passive[k]) * follow.row(k);
    }
};

// Loops by their frames (loops, 2), rods (loops,) and hinges' axes (loops, 3).
extern "C" Peer * peer_make(
    const char * path, int loops, const int * frames, const double * rods, const double * axes,
    int motors, const int * columns, int tool, const double * home)
{
    Peer * peer = new Peer;
    pinocchio::serialization::loadFromText(peer->model, path);
    const int nv = peer->model.nv, passive = nv - motors;
    int rows = 0;
    for (int k = 0; k < loops; k++) {
        const Eigen::Vector3d axis(axes + 3 * k);
        const bool hinge = !axis.isZero();
        Across across = Across::Zero();
        if (hinge) across << axis.unitOrthogonal(), axis.cross(axis.unitOrthogonal());
        const int own = rods[k] > 0.0 ? 1 : hinge ? 5 : 3;
        peer->loops.push_back({frames[2 * k], frames[2 * k + 1], own, rods[k], axis, across});
        rows += own;
    }
    peer->data = pinocchio::Data(peer->model);
    peer->motors.assign(columns, columns + motors), peer->tool = tool;
    for (int k = 0; k < nv; k++)
        if (std::find(columns, columns + motors, k) == columns + motors) peer->passive.push_back(k);
    peer->q = peer->home = Eigen::Map<const Vector>(home, peer->model.nq);
    peer->residual.setZero(rows), peer->jacobian.setZero(rows, nv), peer->rates.setZero(nv);
    peer->one.setZero(6, nv), peer->other.setZero(6, nv);
    peer->K.setZero(passive, motors), peer->K_star.setZero(passive, passive);
    peer->kept_residual.setZero(passive);
    peer->evaluate();
    Matrix columns_of_rows(passive, rows);
    for (int k = 0; k < passive; k++)
        columns_of_rows.row(k) = peer->jacobian.col(peer->passive[k]).transpose();
    const Eigen::ColPivHouseholderQR<Matrix> qr(columns_of_rows);
    const auto & order = qr.colsPermutation().indices();
    peer->kept.assign(order.data(), order.data() + passive);
    peer->factorise();
    peer->at_home = peer->lu.solve(peer->K);
    return peer;
}

// Motors' displacements (count, motors) from home; J_eq (count, 6, motors) and radii (count, 6).
// Returns how many are closed.
extern "C" int peer_run(
    Peer * peer, int count, const double * displacement, double tolerance, double * J_eq,
    double * radii)
{
    const int motors = peer->motors.size();
    Eigen::Matrix<double, 3, Eigen::Dynamic> half(3, motors);
    int closed = 0;
    for (int pose = 0; pose < count; pose++) {
        const Eigen::Map<const Vector> way(displacement + motors * pose, motors);
        closed += peer->close(way, tolerance);
        Columns found(J_eq + 6 * motors * pose, 6, motors);
        peer->tool_jacobian(found);
        for (int block = 0; block < 2; block++) {
            half = found.middleRows<3>(3 * block);
            const Eigen::JacobiSVD<Matrix> svd(half);
            for (int k = 0; k < 3; k++)
                radii[6 * pose + 3 * block + k] =
                    k < svd.singularValues().size() ? svd.singularValues()[k] : 0.0;
        }
    }
    return closed;
}
