"""File formats: project files, gears of one's own, scans."""
