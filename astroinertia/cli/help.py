"""What `astroinertia --help` says."""

DESCRIPTION = (
    "Evolves rotating, self-gravitating fluid bodies and follows their inertia tensor through its own equation."
)
EXAMPLES = """\
a first session:
  astroinertia new star.toml                 write a commented scene, to edit
  astroinertia plan star.toml                see what would be run, and why
  astroinertia run star.toml                 run it; the result is runs/<name>/<name>.nc
  astroinertia show runs/<name>              a summary, and pictures beside the file
  astroinertia guide                         the guide: its topics; astroinertia guide first-run to begin

more:
  astroinertia run star.toml --set body.particles=5000 --set "time.end=2 s" --output runs/coarse
  astroinertia movie runs/<name>             a film of the body; report and view: pages for a browser
  astroinertia compare runs/coarse runs/fine  the same quantities of several runs or models, and how far they differ
  astroinertia tradeoff star.toml            what accuracy costs: errors and times, knob by knob
  astroinertia moments particles.csv         the inertia tensor of a particle table, a mesh or a snapshot
  astroinertia export runs/coarse --to vtk   for other programs: GADGET, SWIFT, ParaView, CSV, Zarr
  astroinertia ratios --body Mars            moment ratios of the solar system, and cores that they allow
  astroinertia verify                        every cross-check with its source: does this installation compute right?
  astroinertia calibrate                     measure this machine, so that plans tell how long runs take
  astroinertia verify --hard                 eighty hard cases of particles, and what stable means for each
  astroinertia run grid.toml --workers 4     a scene with [sweep]: many runs, and one dataset of all
  astroinertia resume runs/coarse            go on after Ctrl-C, a crash or a power cut
  python -c "import xarray; print(xarray.open_dataset('runs/coarse/<name>.nc'))"
"""
