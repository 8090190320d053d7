"""A rendering process of `marine_mj.render_jobs`: raw frames on standard output."""

import os
import pickle
import sys


def main(file: str, worker: int, workers: int) -> None:
    """Write this worker's frames of the job in `file` to standard output, in order."""
    # Whatever a driver prints must not end up in the pictures.
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    from marine_mj.render_jobs import worker_of

    with open(file, "rb") as stream:
        job = pickle.load(stream)
    renderer = job.renderer()
    for i in range(len(job)):
        if worker_of(i, workers) == worker:
            output.write(renderer.frame(i).tobytes())
            output.flush()
    renderer.close()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
    # Some drivers crash when the interpreter tears them down; the work is done.
    os._exit(0)
