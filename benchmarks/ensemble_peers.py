"""Trajectories of 50 periods per second and core with heyoka's batch integrator and with diffrax, as JSON.

Run by `ensemble.py --peers PYTHON` in an environment with `pip install heyoka diffrax`. Each entry is the rate and the
largest error of the final state against the reference given on the command line (states at omega 0.9, 1.0, 1.1).
"""

import json
import os
import sys
import time

os.environ |= {"OMP_NUM_THREADS": "1", "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"}

import numpy as np

OMEGAS = np.linspace(0.9, 1.1, 2048)


def with_heyoka(tolerance, exact):
    """Rate and error of taylor_adaptive_batch with the widest vectors."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    width = hy.recommended_simd_size()
    forces = hy.cos(hy.par[0] * hy.time) - 0.1 * v - x - 0.05 * x * x * x
    batch = hy.taylor_adaptive_batch(
        [(x, v), (v, forces)], np.zeros((2, width)), pars=np.ones((1, width)), tol=tolerance
    )

    def end(omegas):
        batch.state[:], batch.pars[0] = 0.0, omegas
        batch.set_time(np.zeros(width))
        batch.propagate_until(100.0 * np.pi / omegas)
        return batch.state.copy()

    error = max(
        float(np.max(np.abs(end(np.full(width, w))[:, 0] - wanted)))
        for w, wanted in zip((0.9, 1.0, 1.1), exact, strict=True)
    )
    start = time.process_time()
    for i in range(0, len(OMEGAS), width):
        end(OMEGAS[i : i + width])
    return len(OMEGAS) / (time.process_time() - start), error


def with_diffrax(tolerance, exact):
    """Rate and error of Tsit5 under vmap."""
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    def field(t, y, omega):
        return jnp.array([y[1], jnp.cos(omega * t) - 0.1 * y[1] - y[0] - 0.05 * y[0] ** 3])

    def end(omega):
        return diffrax.diffeqsolve(
            diffrax.ODETerm(field),
            diffrax.Tsit5(),
            0.0,
            100.0 * jnp.pi / omega,
            0.01,
            jnp.zeros(2),
            args=omega,
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
            max_steps=100_000,
            saveat=diffrax.SaveAt(t1=True),
        ).ys[0]

    together = jax.jit(jax.vmap(end))
    few = np.asarray(together(jnp.array([0.9, 1.0, 1.1])))
    omegas = jnp.asarray(OMEGAS)
    together(omegas).block_until_ready()
    start = time.process_time()
    together(omegas).block_until_ready()
    return len(OMEGAS) / (time.process_time() - start), float(np.max(np.abs(few - np.asarray(exact))))


if __name__ == "__main__":
    exact = json.loads(sys.argv[1])
    found = {}
    for name, run, tolerances in (("heyoka", with_heyoka, (1e-6, 1e-7, 1e-9)), ("diffrax", with_diffrax, (1e-7,))):
        for tolerance in tolerances:
            found[f"{name} {tolerance:g}"] = run(tolerance, exact)
    print(json.dumps(found))
