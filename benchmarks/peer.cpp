// Tight C++ on Pinocchio's library, to compare with: poses by Newton's method from home, J_eq by one
// factorisation of K*, and the singular values of its linear and angular rows. No step is certain,
// no pose is told to be singular: it is as little as one can do.
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/multibody.hpp>
#include <pinocchio/serialization.hpp>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <vector>

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Linear = Eigen::Matrix<double, 6, Eigen::Dynamic>;

struct Peer
{
    pinocchio::Model model;
    pinocchio::Data data;
    std::vector<int> frames, motors, passive;
    std::vector<double> rods; // 0 where two points are one
    int tool;
    Vector home, q, residual, step, rates;
    Matrix jacobian, K, K_star, follow;
    Linear one, other;

    void evaluate()
    {
        pinocchio::computeJointJacobians(model, data, q);
        pinocchio::updateFramePlacements(model, data);
        for (std::size_t loop = 0, row = 0; loop < rods.size(); loop++) {
            const int first = frames[2 * loop], second = frames[2 * loop + 1];
            one.setZero(), other.setZero();
            getFrameJacobian(model, data, first, pinocchio::LOCAL_WORLD_ALIGNED, one);
            getFrameJacobian(model, data, second, pinocchio::LOCAL_WORLD_ALIGNED, other);
            const Eigen::Vector3d gap =
                data.oMf[first].translation() - data.oMf[second].translation();
            one -= other;
            if (rods[loop] > 0.0) {
                residual[row] = 0.5 * (gap.squaredNorm() / rods[loop] - rods[loop]);
                jacobian.row(row) = gap.transpose() / rods[loop] * one.topRows<3>();
                row += 1;
            } else {
                residual.segment<3>(row) = gap;
                jacobian.middleRows<3>(row) = one.topRows<3>();
                row += 3;
            }
        }
        for (std::size_t k = 0; k < passive.size(); k++) K_star.col(k) = jacobian.col(passive[k]);
    }
};

extern "C" Peer * peer_make(
    const char * path, int loops, const int * frames, const double * rods, int motors,
    const int * columns, int tool, const double * home)
{
    Peer * peer = new Peer;
    pinocchio::serialization::loadFromText(peer->model, path);
    const int nv = peer->model.nv;
    int rows = 0;
    peer->data = pinocchio::Data(peer->model);
    peer->frames.assign(frames, frames + 2 * loops), peer->rods.assign(rods, rods + loops);
    peer->motors.assign(columns, columns + motors), peer->tool = tool;
    for (int k = 0; k < nv; k++)
        if (std::find(columns, columns + motors, k) == columns + motors) peer->passive.push_back(k);
    for (int loop = 0; loop < loops; loop++) rows += rods[loop] > 0.0 ? 1 : 3;
    peer->home = Eigen::Map<const Vector>(home, peer->model.nq);
    peer->residual.setZero(rows), peer->jacobian.setZero(rows, nv);
    peer->K_star.setZero(rows, nv - motors), peer->K.setZero(rows, motors);
    peer->one.setZero(6, nv), peer->other.setZero(6, nv), peer->rates.setZero(nv);
    peer->q = peer->home;
    return peer;
}

// Motors' displacements (count, motors) from home; J_eq (count, 6, motors) and radii (count, 6).
// Returns how many are closed.
extern "C" int peer_run(
    Peer * peer, int count, const double * displacement, double tolerance, double * J_eq,
    double * radii)
{
    const int motors = peer->motors.size(), passive = peer->passive.size();
    int closed = 0;
    // Rows may be redundant, as those of a planar machine: then no LU serves.
    Eigen::ColPivHouseholderQR<Matrix> qr(peer->K_star.rows(), passive);
    Eigen::PartialPivLU<Matrix> lu;
    const bool square = peer->K_star.rows() == passive;
    Eigen::Matrix<double, 3, Eigen::Dynamic> half(3, motors);
    for (int pose = 0; pose < count; pose++) {
        peer->rates.setZero();
        for (int k = 0; k < motors; k++)
            peer->rates[peer->motors[k]] = displacement[pose * motors + k];
        pinocchio::integrate(peer->model, peer->home, peer->rates, peer->q);
        peer->rates.setZero();
        for (int tries = 0; tries < 20; tries++) {
            peer->evaluate();
            if (square) lu.compute(peer->K_star);
            else qr.compute(peer->K_star);
            if (peer->residual.norm() < tolerance) {
                closed++;
                break;
            }
            if (square) peer->step = lu.solve(peer->residual);
            else peer->step = qr.solve(peer->residual);
            for (int k = 0; k < passive; k++) peer->rates[peer->passive[k]] = -peer->step[k];
            peer->q = pinocchio::integrate(peer->model, peer->q, peer->rates);
        }
        for (int k = 0; k < motors; k++) peer->K.col(k) = peer->jacobian.col(peer->motors[k]);
        if (square) peer->follow = lu.solve(peer->K);
        else peer->follow = qr.solve(peer->K);
        peer->one.setZero();
        getFrameJacobian(
            peer->model, peer->data, peer->tool, pinocchio::LOCAL_WORLD_ALIGNED, peer->one);
        Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>> found(
            J_eq + 6 * motors * pose, 6, motors);
        for (int k = 0; k < motors; k++) found.col(k) = peer->one.col(peer->motors[k]);
        for (int k = 0; k < passive; k++)
            found -= peer->one.col(peer->passive[k]) * peer->follow.row(k);
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
