"""What do files of scores look like? Read from anybody's engine, written for anybody's tools."""
